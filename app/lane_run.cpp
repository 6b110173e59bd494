#include "app/lane_run.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "acquisition/errors.h"
#include "acquisition/timestamp.h"
#include "app/source_mapping.h"

namespace vsfind {
namespace {

constexpr std::chrono::minutes between_statistics{1};

}  // namespace

LaneRun::LaneRun(const Lane& lane, std::size_t index, const PipelineOptions& options)
    : lane_(lane),
      index_(index),
      name_(lane.source->info().name),
      max_frames_(options.max_frames),
      queue_length_(options.queue_length),
      frames_(options.queue_length),
      next_statistics_(std::chrono::steady_clock::now() + between_statistics) {
  // As many as may wait for the output, one in the search and one being written.
  if (lane.recorder != nullptr) copies_ = BufferPool::create(static_cast<std::uint32_t>(options.queue_length + 2));
}

void LaneRun::capture() {
  std::shared_ptr<const SourceInfo> info;
  while (auto frame = lane_.source->next()) {
    if (!info) spdlog::info("{}: {}", name_, timestamp_text(frame->info().clock, frame->info().stamped_at));
    if (!info || *info != lane_.source->info()) {
      info = std::make_shared<const SourceInfo>(lane_.source->info());
      if (lane_.drop_oldest) frames_.set_capacity(std::max(queue_length_, frames_that_may_wait(info->frame_rate)));
    }
    watch(*frame);
    Captured captured{std::move(*frame), info};
    if (!lane_.drop_oldest) {
      if (!frames_.push(std::move(captured))) return;
      continue;
    }
    std::optional<Captured> oldest;
    if (!frames_.push_dropping_oldest(std::move(captured), oldest)) return;
    if (const auto count = dropped_.add(oldest ? 1 : 0))
      spdlog::warn("{}: the search does not keep up: {} frames dropped", name_, *count);
  }
}

/// Tells of frames that never came or came broken, and of the camera's own counts now and then.
void LaneRun::watch(const Frame& frame) {
  if (!lane_.drop_oldest) return;
  const std::uint64_t sequence = frame.info().sequence;
  const std::uint64_t gap = last_sequence_ && sequence > *last_sequence_ + 1 ? sequence - *last_sequence_ - 1 : 0;
  last_sequence_ = std::max(sequence, last_sequence_.value_or(0));
  if (const auto count = lost_.add(gap)) spdlog::warn("{}: {} frames were lost before they came here", name_, *count);
  if (const auto count = bad_.add(frame.info().status == FrameStatus::good ? 0 : 1))
    spdlog::warn("{}: {} frames came incomplete or corrupt", name_, *count);
  const auto now = std::chrono::steady_clock::now();
  if (now < next_statistics_) return;
  next_statistics_ = now + between_statistics;
  if (const std::string text = lane_.source->statistics(); !text.empty()) spdlog::info("{}: {}", name_, text);
}

void LaneRun::search(BoundedQueue<LaneResult>& results) {
  std::uint64_t count = 0;
  while (max_frames_ != count) {
    std::optional<Captured> captured = frames_.pop();
    if (!captured) return;
    LaneResult result;
    result.lane = index_;
    result.info = captured->info;
    if (lane_.recorder != nullptr) result.recorded = copy_of(captured->frame);
    try {
      adopt(captured->info);
      result.result = result_of(captured->frame);
      searched_once_ = searched_once_ || !result.result.pictures.empty();
    } catch (const UsageError& error) {
      if (!lane_.drop_oldest || !searched_once_) throw;
      if (refused_.add(1)) spdlog::error("{}; its frames are taken for bad ones until that is over", error.what());
      FrameInfo info = captured->frame.info();
      info.status = FrameStatus::corrupt;
      result.result = lane_.searcher->unsearched(name_, info);
      info_.reset();
    }
    result.result.source_index = index_;
    captured.reset();  // the driver has its buffer back before the output is waited for
    if (!results.push(std::move(result))) return;
    ++count;
  }
  abort();
}

void LaneRun::adopt(const std::shared_ptr<const SourceInfo>& info) {
  if (info_ == info) return;
  check_region(lane_.search, info->width, info->height, name_);
  if (lane_.follow && (info_ == nullptr || info_->pixel_aspect != info->pixel_aspect))
    lane_.searcher->set_mapping(mapping_for(name_, info->pixel_aspect, *lane_.follow));
  info_ = info;
}

FrameResult LaneRun::result_of(const Frame& frame) {
  return lane_.searcher->search(name_, frame.info(), frame.image());
}

std::optional<Frame> LaneRun::copy_of(const Frame& frame) {
  const ImageView& image = frame.image();
  if (image.empty()) return Frame(nullptr, 0, {}, frame.info());
  const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(image.width) * image.bytes_per_pixel();
  auto room = copies_->acquire(static_cast<std::size_t>(row) * static_cast<std::size_t>(image.height));
  if (!room) return std::nullopt;
  ImageView copy = image;
  copy.data = room->data();
  copy.stride = row;
  for (int y = 0; y < image.height; ++y)
    std::memcpy(room->data() + y * row, image.data + y * image.stride, static_cast<std::size_t>(row));
  return std::move(*room).to_frame(copy, frame.info());
}

void LaneRun::abort() {
  lane_.source->stop();  // the capturing thread may wait for a frame that nobody wants any more
  frames_.abort();
  if (copies_) copies_->stop();
}

}  // namespace vsfind
