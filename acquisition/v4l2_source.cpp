#include "acquisition/v4l2_source.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "acquisition/buffer_pool.h"
#include "acquisition/timestamp.h"
#include "acquisition/trouble.h"
#include "acquisition/v4l2_buffers.h"
#include "acquisition/v4l2_controls.h"
#include "acquisition/v4l2_convert.h"
#include "acquisition/v4l2_fields.h"
#include "acquisition/v4l2_input.h"
#include "acquisition/v4l2_picture.h"

namespace vsfind {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;

std::int64_t monotonic_now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * second_ns + now.tv_nsec;
}

class V4l2Source final : public FrameSource {
 public:
  V4l2Source(const std::string& path, const CameraSettings& settings)
      : device_(path), input_(select_input(device_, settings)), picture_(set_picture(device_, input_, settings)) {
    set_controls(device_, settings);
    wake_.reset(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (wake_.get() < 0) throw device_.failure("cannot be waited for", errno);
    const v4l2_pix_format& pix = picture_.format.pix;
    direct_ = luma_layout(pix.pixelformat);
    if (!direct_) {
      try {
        v4l2_format format{};
        format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        format.fmt.pix = pix;
        converter_ = std::make_unique<V4l2Converter>(device_.multi_planar() ? -1 : device_.fd(), format);
      } catch (const std::runtime_error& error) {
        throw UsageError(fmt::format("{}: {}", device_.name(), error.what()));
      }
    }
    fill_info(pix);
    if (holds_one_field(picture_.fields))
      counter_ = SequenceCounter(picture_.fields == BufferFields::alternate ? 2 : 1,
                                 info_.order == FieldOrder::bottom_first ? Field::bottom : Field::top);
    // Long exposures are no fault.
    if (settings.frame_timeout_s > 0) {
      constexpr double periods = 3.0;
      const double period = info_.frame_rate.known() ? 1.0 / info_.frame_rate.value() : 0.0;
      timeout_ms_ = static_cast<int>(std::min(std::max(settings.frame_timeout_s, periods * period) * 1e3, 1e9));
    }
    pool_ = BufferPool::create(recording_buffers(frame_bytes_));
    subscribe();
    buffers_ = std::make_unique<V4l2Buffers>(device_, std::clamp(settings.buffers, 4, 64));
    buffers_->start();
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    while (!stopped_) {
      if (std::optional<Frame> frame = poll_once()) return frame;
    }
    return std::nullopt;
  }

  void stop() noexcept override {
    stopped_ = true;
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(wake_.get(), &one, sizeof one);
    pool_->stop();
  }

  [[nodiscard]] std::string statistics() const override {
    return fmt::format("{} {}, {} lost by the driver, {} bad", received_,
                       holds_one_field(picture_.fields) ? "fields" : "frames", counter_.missing(), bad_);
  }

 private:
  void fill_info(const v4l2_pix_format& pix) {
    info_.name = device_.name();
    info_.live = true;
    info_.width = static_cast<int>(pix.width);
    info_.height = frame_rows(picture_.fields, static_cast<int>(pix.height));
    info_.bits = direct_ ? direct_->bits : 8;
    info_.order = field_order(picture_.fields, input_.lines_525);
    info_.pixel_aspect = picture_.pixel_aspect;
    info_.frame_rate = picture_.frame_rate;
    const std::size_t sample = info_.bits > 8 ? 2 : 1;
    stride_ = static_cast<std::ptrdiff_t>(pix.width * sample);
    frame_bytes_ = static_cast<std::size_t>(stride_) * pix.height;
    rows_ = static_cast<int>(pix.height);
    needed_bytes_ = pix.sizeimage;
    if (direct_) {
      source_stride_ = pix.bytesperline > 0 ? pix.bytesperline : pix.width * static_cast<std::uint32_t>(direct_->step);
      needed_bytes_ = picture_bytes(*direct_, source_stride_, pix.height);
    } else if (pix.bytesperline > 0 && !is_jpeg(pix.pixelformat)) {
      needed_bytes_ = std::min<std::size_t>(pix.sizeimage, std::size_t{pix.bytesperline} * pix.height);
    } else {
      needed_bytes_ = 1;  // compressed: as long as it is
    }
  }

  /// Changes of the signal come as events, where the driver has them; else the input's status is asked for.
  void subscribe() {
    v4l2_event_subscription subscription{};
    subscription.type = V4L2_EVENT_SOURCE_CHANGE;
    subscription.id = input_.index;
    has_events_ = device_.call(VIDIOC_SUBSCRIBE_EVENT, &subscription) == 0;
    can_lose_signal_ = input_.standard != 0 || input_.timings.width > 0;
  }

  void describe(std::uint32_t flags) {
    const auto [clock, stamped_at] = timestamp_kind(flags);
    const v4l2_pix_format& pix = picture_.format.pix;
    report(SourceEvent::Kind::note,
           fmt::format("{}: {} ({}), {}{}{}{}x{} {}, {}, pixel aspect {}:{}, {:.6g} frames per second, {} buffers, {}",
                       info_.name, fixed_text(device_.capability().card), fixed_text(device_.capability().driver),
                       input_.name.empty() ? "" : fmt::format("input '{}', ", input_.name), input_.standard_name,
                       input_.standard_name.empty() ? "" : ", ", info_.width, info_.height,
                       fourcc_name(pix.pixelformat), name(picture_.fields), info_.pixel_aspect.numerator,
                       info_.pixel_aspect.denominator, info_.frame_rate.known() ? info_.frame_rate.value() : 0.0,
                       buffers_->count(), timestamp_text(clock, stamped_at)));
  }

  /// Waits once. Nothing where no frame came of it.
  std::optional<Frame> poll_once() {
    std::array<pollfd, 2> waited{pollfd{device_.fd(), POLLIN | POLLPRI, 0}, pollfd{wake_.get(), POLLIN, 0}};
    const int count = ::poll(waited.data(), waited.size(), timeout_ms_);
    if (count < 0 && errno != EINTR) throw device_.failure("cannot be waited for", errno);
    if (count < 0 || stopped_) return std::nullopt;
    if (count == 0) {
      check_signal();
      throw CameraError(fmt::format("{}: no frame for {:.3g} s", info_.name, timeout_ms_ / 1e3));
    }
    const auto events = static_cast<unsigned>(waited[0].revents);
    // Before the frames: what comes after a change of the signal is not what it is taken for.
    if ((events & POLLPRI) != 0) take_events();
    if (can_lose_signal_ && !has_events_) check_signal();
    constexpr unsigned broken = POLLERR | POLLHUP | POLLNVAL;
    if ((events & (POLLIN | broken)) != 0) return take_frame((events & broken) != 0);
    return std::nullopt;
  }

  void check_signal() const {
    if (const std::string problem = signal_problem(device_); !problem.empty())
      throw CameraError(fmt::format("{}: {}", info_.name, problem));
  }

  void take_events() {
    v4l2_event event{};
    while (device_.call(VIDIOC_DQEVENT, &event) == 0) {
      if (event.type != V4L2_EVENT_SOURCE_CHANGE) continue;
      check_signal();
      throw CameraError(fmt::format("{}: the signal has changed", info_.name));
    }
  }

  /// `broken`: the system says that something is wrong; taking a buffer tells what.
  std::optional<Frame> take_frame(bool broken) {
    v4l2_buffer buffer{};
    std::span<const std::byte> filled;
    switch (const int error = buffers_->take(buffer, filled)) {
      case 0:
        break;
      case EAGAIN:
        if (!broken) return std::nullopt;
        [[fallthrough]];
      case EIO:
        throw CameraError(fmt::format("{}: the stream broke off (input/output error)", info_.name));
      default:
        throw device_.failure("gives no more frames", error);
    }
    const std::int64_t arrival = monotonic_now_ns();
    if (buffer.index >= buffers_->count())
      throw CameraError(fmt::format("{}: names a buffer that it does not have", info_.name));
    std::optional<Frame> frame;
    try {
      frame = make_frame(buffer, filled, arrival);
    } catch (const std::bad_alloc&) {
      throw CameraError(fmt::format("{}: no memory for its frames", info_.name));
    }
    if (!stopped_) buffers_->give(buffer.index);
    return frame;
  }

  /// Copies luma out, so that the buffer can go back to the driver at once. Nothing after stop().
  std::optional<Frame> make_frame(const v4l2_buffer& buffer, std::span<const std::byte> memory, std::int64_t arrival) {
    if (!std::exchange(described_, true)) describe(buffer.flags);
    FrameInfo info;
    info.arrival_ns = arrival;
    info.order = info_.order;
    std::tie(info.clock, info.stamped_at) = timestamp_kind(buffer.flags);
    if (info.clock != Clock::none) {
      constexpr std::int64_t microsecond_ns = 1000;
      info.timestamp_ns = std::int64_t{buffer.timestamp.tv_sec} * second_ns + buffer.timestamp.tv_usec * microsecond_ns;
    }
    const auto field = picture_field(picture_.fields, static_cast<BufferFields>(buffer.field));
    info.field = field.value_or(Field::top);
    info.sequence = counter_.next(buffer.sequence, info.field);
    ++received_;

    auto lease = pool_->acquire(frame_bytes_);
    if (!lease) return std::nullopt;
    ImageView image{lease->data(), info_.width, rows_, stride_, info_.bits};
    std::string why;
    if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) {
      info.status = FrameStatus::corrupt;
      why = "flagged by the driver";
    } else if (memory.size() < needed_bytes_) {
      info.status = FrameStatus::incomplete;
      why = fmt::format("{} bytes of {}", memory.size(), needed_bytes_);
    } else if (!field) {
      info.status = FrameStatus::corrupt;
      why = "the driver does not say which field it is";
    } else if (const std::string complaint = fill(memory, lease->data()); !complaint.empty()) {
      info.status = FrameStatus::corrupt;
      why = complaint;
    }
    if (info.status != FrameStatus::good) {
      ++bad_;
      image = {};
    }
    note_trouble(why);
    return std::move(*lease).to_frame(image, info);
  }

  /// What is wrong with the buffer, or nothing.
  std::string fill(std::span<const std::byte> memory, std::byte* target) {
    if (direct_) {
      unpack(*direct_, picture_.fields, memory.data(), static_cast<std::ptrdiff_t>(source_stride_), info_.width, rows_,
             target, stride_);
      return {};
    }
    std::span<const std::byte> luma;
    try {
      luma = converter_->luma(memory);
    } catch (const std::runtime_error& error) {
      throw CameraError(fmt::format("{}: {}", info_.name, error.what()));
    }
    if (luma.empty()) return converter_->complaint();
    unpack(LumaLayout{}, picture_.fields, luma.data(), info_.width, info_.width, rows_, target, stride_);
    return {};
  }

  /// Lost and bad frames are told of when they begin, and when they are over.
  void note_trouble(const std::string& why) {
    const char* unit = holds_one_field(picture_.fields) ? "fields" : "frames";
    using enum Trouble::Change;
    if (const auto change = lost_.update(counter_.missing_before()); change == begun) {
      report(SourceEvent::Kind::fault, fmt::format("{}: the driver is losing {}", info_.name, unit));
    } else if (change == ended) {
      report(SourceEvent::Kind::recovered,
             fmt::format("{}: no {} are lost any more ({} were)", info_.name, unit, lost_.count()));
    }
    if (const auto change = bad_frames_.update(why.empty() ? 0 : 1); change == begun) {
      report(SourceEvent::Kind::fault, fmt::format("{}: bad {}: {}", info_.name, unit, why));
    } else if (change == ended) {
      report(SourceEvent::Kind::recovered,
             fmt::format("{}: the {} are good again ({} were bad)", info_.name, unit, bad_frames_.count()));
    }
  }

  V4l2Device device_;
  V4l2Input input_;
  V4l2Picture picture_;
  SourceInfo info_;
  std::optional<LumaLayout> direct_;
  std::unique_ptr<V4l2Converter> converter_;
  std::ptrdiff_t stride_ = 0;  // of a Frame's rows
  std::uint32_t source_stride_ = 0;
  std::size_t frame_bytes_ = 0;
  std::size_t needed_bytes_ = 0;
  int rows_ = 0;
  int timeout_ms_ = -1;
  bool has_events_ = false;
  bool can_lose_signal_ = false;
  bool described_ = false;
  SequenceCounter counter_;
  std::uint64_t received_ = 0;
  std::uint64_t bad_ = 0;
  Trouble lost_;
  Trouble bad_frames_;
  UniqueFd wake_;
  std::atomic<bool> stopped_ = false;
  std::shared_ptr<BufferPool> pool_;
  std::unique_ptr<V4l2Buffers> buffers_;
};

}  // namespace

std::unique_ptr<FrameSource> open_v4l2(const std::string& device, const CameraSettings& settings) {
  return std::make_unique<V4l2Source>(device, settings);
}

}  // namespace vsfind
