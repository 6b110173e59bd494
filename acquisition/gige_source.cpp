#include "acquisition/gige_source.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <utility>

#include "acquisition/buffer_pool.h"
#include "acquisition/errors.h"
#include "acquisition/gige_camera.h"
#include "acquisition/gige_field_count.h"
#include "acquisition/gige_frame_count.h"
#include "acquisition/network_path.h"
#include "acquisition/weave.h"

namespace vsfind {
namespace gige {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// Frames that the rest of the program may hold beside those that wait, while the camera still finds all its buffers
/// free.
constexpr int lent_beside = 4;
constexpr std::uint64_t poll_us = 50'000;  // how long stop() may take to be noticed

std::int64_t monotonic_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(SteadyClock::now().time_since_epoch()).count();
}

/// The stream with its buffers. Those that are lent to frames come back when the frames go, even after the stream.
class StreamBuffers final : public BufferOwner {
 public:
  StreamBuffers(ArvStream* stream, int count, std::size_t bytes) : stream_(stream) {
    lent_.resize(static_cast<std::size_t>(count), nullptr);
    for (int i = 0; i < count; ++i) {
      // The user data tells the buffer's place; 0 would be no user data.
      arv_stream_push_buffer(stream, arv_buffer_new_full(bytes, nullptr, GSIZE_TO_POINTER(i + 1), nullptr));
    }
  }
  ~StreamBuffers() override {
    for (ArvBuffer* buffer : lent_) {
      if (buffer != nullptr) g_object_unref(buffer);
    }
  }

  std::uint32_t lend(ArvBuffer* buffer) {
    const auto index = static_cast<std::uint32_t>(GPOINTER_TO_SIZE(arv_buffer_get_user_data(buffer)) - 1);
    const std::lock_guard lock(mutex_);
    lent_[index] = buffer;
    return index;
  }

  void give_back(std::uint32_t index) noexcept override {
    const std::lock_guard lock(mutex_);
    ArvBuffer* const buffer = std::exchange(lent_[index], nullptr);
    if (buffer == nullptr) return;
    if (stream_ != nullptr) {
      arv_stream_push_buffer(stream_, buffer);
    } else {
      g_object_unref(buffer);
    }
  }

  /// From now on buffers are freed as they come back.
  void part_from_stream() {
    const std::lock_guard lock(mutex_);
    stream_ = nullptr;
  }

 private:
  std::mutex mutex_;
  ArvStream* stream_;
  std::vector<ArvBuffer*> lent_;
};

class GigeSource final : public FrameSource {
 public:
  GigeSource(const std::string& name, const CameraSettings& settings) : settings_(settings) {
    info_.name = "gige:" + name;
    // Asked first, without the lock: a camera that is not there is told in a fraction of the time, and does not keep
    // the others waiting.
    if (is_ipv4_address(name) && !answers_discovery(name))
      throw CameraError(fmt::format("{}: no camera answers", info_.name));
    const auto lock = lock_opening();
    camera_ = find_camera(info_.name, name);
    setup_ = set_up(camera_.get(), info_.name, settings);
    describe();
    if (!setup_.pixels.direct() || setup_.fields == Fields::concatenated)
      converted_ = BufferPool::create(static_cast<std::uint32_t>(settings.buffers + lent_at_once()));
    start();
  }

  ~GigeSource() override {
    const auto lock = lock_opening();
    if (stream_) {
      CallError ignored;
      // A lost camera answers nothing: every register would cost seconds of waiting.
      if (!lost_ && !silent_) arv_camera_stop_acquisition(camera_.get(), ignored.out());
      g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera_.get()), this);
      buffers_->part_from_stream();
      stream_.reset();
    }
    camera_.reset();
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }

  void stop() noexcept override { stopped_ = true; }

  std::optional<Frame> next() override {
    const auto begin = SteadyClock::now();
    while (!stopped_) {
      if (lost_) throw CameraError(fmt::format("{}: the camera does not answer any more", info_.name));
      fire();
      ArvBuffer* const buffer = arv_stream_timeout_pop_buffer(stream_.get(), poll_us);
      if (buffer == nullptr) {
        check_silence(begin);
        continue;
      }
      if (auto frame = frame_of(buffer)) return frame;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::string statistics() const override {
    const auto count = [this](const char* name) { return arv_stream_get_info_uint64_by_name(stream_.get(), name); };
    return fmt::format(
        "{} frames complete, {} failed, {} packets without a free buffer, {} packets missing, {} resent, {} frames of "
        "wrong "
        "size",
        count("n_completed_buffers"), count("n_failures"), count("n_underruns"), count("n_missing_packets"),
        count("n_resent_packets"), count("n_size_mismatch_errors") + short_frames_);
  }

 private:
  static void on_control_lost(ArvGvDevice* /*device*/, gpointer self) { static_cast<GigeSource*>(self)->lost_ = true; }

  static void on_stream_event(void* /*self*/, ArvStreamCallbackType type, ArvBuffer* /*buffer*/) {
    constexpr int nice_level = -10;
    if (type == ARV_STREAM_CALLBACK_TYPE_INIT && arv_make_thread_high_priority(nice_level) == FALSE)
      spdlog::debug("the receiving thread has no raised priority: not permitted");
  }

  void describe() {
    info_.width = setup_.width;
    info_.height = setup_.height * (is_single(setup_.fields) ? 2 : 1);
    info_.bits = setup_.pixels.bits;
    info_.order = setup_.order;
    info_.live = true;
    constexpr double milli = 1000.0;
    if (setup_.frame_rate > 0.0 && setup_.frame_rate < 1e6)
      info_.frame_rate = {std::llround(setup_.frame_rate * milli), 1000};
  }

  [[nodiscard]] int lent_at_once() const {
    return lent_beside + static_cast<int>(frames_that_may_wait(info_.frame_rate));
  }

  void start() {
    CallError error;
    stream_.reset(arv_camera_create_stream(camera_.get(), on_stream_event, this, error.out()));
    if (!stream_) throw CameraError(fmt::format("{}: cannot be received: {}", info_.name, error.text()));
    const std::size_t several_frames = std::max<std::size_t>(4 * setup_.payload, std::size_t{2} << 20U);
    const auto buffer = settings_.socket_buffer > 0
                            ? settings_.socket_buffer
                            : static_cast<int>(std::min<std::size_t>(several_frames, std::size_t{256} << 20U));
    if (const long limit = max_receive_buffer(); limit > 0 && static_cast<std::size_t>(limit) < setup_.payload)
      spdlog::warn(
          "{}: the kernel's receive buffers hold {} bytes, a frame has {}: frames may be lost (sysctl "
          "net.core.rmem_max={} helps)",
          info_.name, limit, setup_.payload, buffer);
    // A running thread would take the buffer's size to heart after the first frame only, and lose that.
    arv_stream_stop_thread(stream_.get(), FALSE);
    g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size", buffer,
                 "packet-resend",
                 settings_.packet_resend ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER,
                 nullptr);
    arv_stream_start_thread(stream_.get());
    buffers_ = std::make_shared<StreamBuffers>(stream_.get(), settings_.buffers + (converted_ ? 0 : lent_at_once()),
                                               setup_.payload);
    g_signal_connect(arv_camera_get_device(camera_.get()), "control-lost", G_CALLBACK(on_control_lost), this);
    arv_camera_start_acquisition(camera_.get(), error.out());
    last_sign_ = SteadyClock::now();
    if (error) throw CameraError(fmt::format("{}: cannot be started: {}", info_.name, error.text()));
  }

  /// A software trigger, where one is due.
  void fire() {
    if (!setup_.software_trigger) return;
    const auto now = SteadyClock::now();
    const bool due =
        settings_.trigger_rate > 0.0 ? now >= next_trigger_ : !waiting_for_trigger_ || now >= next_trigger_;
    if (!due) return;
    const double period = settings_.trigger_rate > 0.0 ? 1.0 / settings_.trigger_rate : 0.5;  // s, or one more try
    const auto step = std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(period));
    // In step with the rate, but no burst after a pause.
    next_trigger_ = settings_.trigger_rate > 0.0 && now - next_trigger_ < step ? next_trigger_ + step : now + step;
    CallError error;
    arv_camera_software_trigger(camera_.get(), error.out());
    if (error) throw CameraError(fmt::format("{}: cannot be triggered: {}", info_.name, error.text()));
    waiting_for_trigger_ = true;
  }

  void check_silence(SteadyClock::time_point begin) {
    if (setup_.hardware_trigger || settings_.frame_timeout_s <= 0.0) return;  // triggers may be far apart
    double seconds = settings_.frame_timeout_s;
    const double rate = setup_.software_trigger ? settings_.trigger_rate : setup_.frame_rate;
    if (rate > 0.0) seconds = std::max(seconds, 3.0 / rate);
    const auto since = std::max(begin, last_sign_);
    if (SteadyClock::now() - since < std::chrono::duration<double>(seconds)) return;
    silent_ = true;
    throw CameraError(fmt::format("{}: no frame for {:.1f} s", info_.name, seconds));
  }

  /// The frame in a buffer, which goes back at once where nothing of it is needed; nothing where it holds no frame.
  std::optional<Frame> frame_of(ArvBuffer* buffer) {
    FrameInfo info;
    info.arrival_ns = monotonic_now_ns();
    info.order = setup_.order;
    if (is_single(setup_.fields)) info.field = setup_.fields == Fields::bottom ? Field::bottom : Field::top;
    const ArvBufferStatus status = arv_buffer_get_status(buffer);
    last_sign_ = SteadyClock::now();
    waiting_for_trigger_ = false;
    // The status first: without success there may be no image, and what is known of the frame may be old.
    if (status != ARV_BUFFER_STATUS_SUCCESS) {
      const bool is_frame = status != ARV_BUFFER_STATUS_CLEARED && status != ARV_BUFFER_STATUS_ABORTED &&
                            status != ARV_BUFFER_STATUS_FILLING && status != ARV_BUFFER_STATUS_UNKNOWN;
      std::optional<Frame> frame;
      if (is_frame) {
        bool known = false;
        info.status = FrameStatus::incomplete;
        const std::uint64_t id = arv_buffer_get_frame_id(buffer);
        if (setup_.fields == Fields::in_turn) {
          put(field_count_.of_broken_field(id, known), info);
        } else {
          info.sequence = count_.of_broken_frame(id, known);
        }
        if (known) stamp(buffer, info);
        frame.emplace(nullptr, 0, ImageView{}, info);
      }
      arv_stream_push_buffer(stream_.get(), buffer);
      return frame;
    }
    if (setup_.fields == Fields::in_turn) {
      put(field_count_.of_whole_field(arv_buffer_get_frame_id(buffer)), info);
    } else {
      info.sequence = count_.of_whole_frame(arv_buffer_get_frame_id(buffer));
    }
    stamp(buffer, info);
    const std::optional<ImageView> raw = image_of(buffer);
    if (!raw) {
      ++short_frames_;
      info.status = FrameStatus::incomplete;
      arv_stream_push_buffer(stream_.get(), buffer);
      return Frame(nullptr, 0, ImageView{}, info);
    }
    const std::uint32_t index = buffers_->lend(buffer);
    Frame lease(buffers_, index, *raw, info);
    if (!converted_) return lease;
    return converted(lease);
  }

  /// The first field of a frame is the earlier one.
  void put(const GigeFieldCount::Place& place, FrameInfo& info) const {
    info.sequence = place.frame;
    const bool top = place.second == (setup_.order == FieldOrder::bottom_first);
    info.field = top ? Field::top : Field::bottom;
  }

  static void stamp(ArvBuffer* buffer, FrameInfo& info) {
    info.timestamp_ns = static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer));
    info.clock = Clock::device;
    if (info.timestamp_ns != 0) return;
    info.timestamp_ns = static_cast<std::int64_t>(arv_buffer_get_system_timestamp(buffer));
    info.clock = Clock::realtime;
  }

  /// The pixels as they arrived; nothing where their number is not that of a frame.
  std::optional<ImageView> image_of(ArvBuffer* buffer) const {
    if (arv_buffer_get_n_parts(buffer) == 0) return std::nullopt;
    std::size_t bytes = 0;
    const auto* const data = static_cast<const std::byte*>(arv_buffer_get_image_data(buffer, &bytes));
    const int width = arv_buffer_get_image_width(buffer);
    const int height = arv_buffer_get_image_height(buffer);
    int padding_x = 0;
    int padding_y = 0;
    arv_buffer_get_image_padding(buffer, &padding_x, &padding_y);
    if (data == nullptr || width != setup_.width || height != setup_.height || padding_x < 0) return std::nullopt;
    const auto pixels = gige_pixels(static_cast<std::uint32_t>(arv_buffer_get_image_pixel_format(buffer)));
    if (!pixels || pixels->bits != setup_.pixels.bits || pixels->colour != setup_.pixels.colour ||
        pixels->packing != setup_.pixels.packing)
      return std::nullopt;
    const bool padded = padding_x > 0 && pixels->packing == GigePixels::Packing::plain;
    const std::size_t row = pixels->bytes(width, 1) + (padded ? static_cast<std::size_t>(padding_x) : 0);
    const std::size_t needed = padded ? row * static_cast<std::size_t>(height) : pixels->bytes(width, height);
    // What the image should have, and what really came: cut packets are complete in all but their bytes.
    std::size_t received = 0;
    static_cast<void>(arv_buffer_get_data(buffer, &received));
    if (bytes < needed || received < needed) return std::nullopt;
    return ImageView{data, width, height, static_cast<std::ptrdiff_t>(row), pixels->bits};
  }

  /// A frame of our own, so that the camera's buffer goes back at once.
  std::optional<Frame> converted(const Frame& lease) {
    const ImageView& raw = lease.image();
    const std::size_t bytes = static_cast<std::size_t>(raw.width) * static_cast<std::size_t>(raw.height) *
                              static_cast<std::size_t>(raw.bytes_per_pixel());
    // Room for two pictures where the fields are put together afterwards.
    const bool weaves = setup_.fields == Fields::concatenated;
    auto room = converted_->acquire(weaves ? 2 * bytes : bytes);
    if (!room) return std::nullopt;
    std::byte* const target = weaves ? room->data() + bytes : room->data();
    ImageView luma = raw;
    if (!setup_.pixels.direct())
      luma = luma_from_gige(setup_.pixels, raw.data, raw.width, raw.height,
                            setup_.pixels.packing == GigePixels::Packing::plain ? raw.stride : 0, target);
    if (weaves) {
      ImageView top = luma;
      top.height = luma.height / 2;
      ImageView bottom = top;
      bottom.data = luma.data + top.height * luma.stride;
      luma = weave(top, bottom, room->data(), static_cast<std::ptrdiff_t>(luma.width) * luma.bytes_per_pixel());
    }
    return std::move(*room).to_frame(luma, lease.info());
  }

  CameraSettings settings_;
  SourceInfo info_;
  ObjectPtr<ArvCamera> camera_;
  Setup setup_;
  std::shared_ptr<BufferPool> converted_;  // where frames are not lent as they arrive
  std::shared_ptr<StreamBuffers> buffers_;
  ObjectPtr<ArvStream> stream_;
  GigeFrameCount count_;
  GigeFieldCount field_count_;  // instead, where fields come in turn
  std::uint64_t short_frames_ = 0;
  SteadyClock::time_point last_sign_;
  SteadyClock::time_point next_trigger_;
  bool waiting_for_trigger_ = false;
  bool silent_ = false;
  std::atomic<bool> lost_ = false;
  std::atomic<bool> stopped_ = false;
};

}  // namespace
}  // namespace gige

std::unique_ptr<FrameSource> open_gige(const std::string& name, const CameraSettings& settings) {
  return std::make_unique<gige::GigeSource>(name, settings);
}

}  // namespace vsfind
