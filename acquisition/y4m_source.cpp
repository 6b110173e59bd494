#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <new>
#include <utility>

#include "acquisition/buffer_pool.h"
#include "acquisition/byte_reader.h"
#include "acquisition/errors.h"
#include "acquisition/recording.h"
#include "acquisition/y4m_header.h"

namespace vsfind {
namespace {

static_assert(y4m_max_line <= ByteReader::line_capacity);

std::int64_t monotonic_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Y4mHeader read_header(ByteReader& reader, const std::string& path) {
  const ByteReader::Line line = reader.read_line();
  if (line.status == ByteReader::LineStatus::ended && line.text.empty())
    throw IoError(fmt::format("{}: is empty, not a YUV4MPEG2 recording", path));
  try {
    const Y4mHeader header = parse_y4m_header(line.text);
    if (line.status == ByteReader::LineStatus::whole) return header;
  } catch (const IoError& error) {
    throw IoError(fmt::format("{}: {}", path, error.what()));
  }
  throw IoError(line.status == ByteReader::LineStatus::ended
                    ? fmt::format("{}: is cut off within its header", path)
                    : fmt::format("{}: its header is longer than the allowed {} bytes", path, y4m_max_line));
}

/// The number of whole frames of a regular file whose frame lines are all as long as the first one, which a few places
/// spread over the file confirm; else nothing.
std::optional<std::uint64_t> count_frames(const ByteReader& reader, std::size_t frame_bytes) {
  const std::optional<std::uint64_t> rest = reader.remaining();
  if (!rest) return std::nullopt;
  const auto line_length = [&](std::uint64_t offset) -> std::uint64_t {
    std::array<char, y4m_max_line> bytes;
    const ssize_t count =
        ::pread(reader.fd(), bytes.data(), bytes.size(), static_cast<off_t>(reader.position() + offset));
    const std::string_view text(bytes.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
    const std::size_t newline = text.find('\n');
    return text.starts_with("FRAME") && newline != std::string_view::npos ? newline + 1 : 0;
  };
  const std::uint64_t first = line_length(0);
  if (first == 0) return *rest == 0 ? std::optional<std::uint64_t>(0) : std::nullopt;
  const std::uint64_t period = first + frame_bytes;
  const std::uint64_t frames = *rest / period;
  constexpr std::uint64_t places = 16;
  for (std::uint64_t i = 1; i <= places && frames > 1; ++i) {
    if (line_length((frames - 1) * i / places * period) != first) return std::nullopt;
  }
  return frames;
}

class Y4mSource final : public FrameSource {
 public:
  explicit Y4mSource(const std::string& path) : path_(path), reader_(path), header_(read_header(reader_, path)) {
    info_.name = path;
    info_.width = header_.width;
    info_.height = header_.height;
    info_.bits = header_.bits;
    info_.order = header_.order;
    info_.pixel_aspect = header_.pixel_aspect;
    info_.frame_rate = header_.frame_rate;
    info_.frames = count_frames(reader_, header_.luma_bytes + header_.chroma_bytes);
    pool_ = BufferPool::create(recording_buffers(header_.luma_bytes));
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (ended_ || reader_.stopped()) return std::nullopt;
    try {
      std::optional<Frame> frame = read_frame();
      ended_ = !frame.has_value();
      index_ += frame ? 1 : 0;
      return frame;
    } catch (const std::exception&) {
      ended_ = true;
      throw;
    }
  }

  void stop() noexcept override {
    reader_.stop();
    pool_->stop();
  }

 private:
  std::optional<Frame> read_frame() {
    const std::optional<Y4mFrameLine> line = read_frame_line();
    if (!line) return std::nullopt;
    // Known to be short before a buffer is taken: a small file cannot ask for a large one.
    const std::uint64_t frame_bytes = std::uint64_t{header_.luma_bytes} + header_.chroma_bytes;
    if (const auto rest = reader_.remaining(); rest && *rest < frame_bytes) throw cut_off(frame_bytes - *rest);

    std::optional<BufferPool::Lease> lease = take_buffer();
    if (!lease) return std::nullopt;
    const std::size_t luma = reader_.read(lease->data(), header_.luma_bytes);
    const std::size_t chroma = luma == header_.luma_bytes ? reader_.skip(header_.chroma_bytes) : 0;
    if (reader_.stopped()) return std::nullopt;
    if (luma + chroma < frame_bytes) throw cut_off(frame_bytes - luma - chroma);
    if constexpr (std::endian::native == std::endian::big) swap_bytes(lease->data());

    ImageView image{lease->data(), header_.width, header_.height, 0, header_.bits};
    image.stride = static_cast<std::ptrdiff_t>(image.width) * image.bytes_per_pixel();
    const FrameInfo frame_info = info_of_frame(*line);
    image = line->tag && line->tag->empty ? ImageView{} : field_view(image, frame_info.field);
    return std::move(*lease).to_frame(image, frame_info);
  }

  /// Nothing at the end of the recording and after stop().
  std::optional<Y4mFrameLine> read_frame_line() {
    const std::uint64_t begin = reader_.position();
    const ByteReader::Line line = reader_.read_line();
    if (reader_.stopped() || (line.status == ByteReader::LineStatus::ended && line.text.empty())) return std::nullopt;
    try {
      if (line.status == ByteReader::LineStatus::whole) return parse_y4m_frame_line(line.text);
      constexpr std::string_view magic = "FRAME";
      if (line.text.substr(0, magic.size()) != magic.substr(0, line.text.size()))
        static_cast<void>(parse_y4m_frame_line(line.text));  // throws: something else than a frame begins here
    } catch (const IoError& error) {
      throw IoError(fmt::format("{}: frame {} is damaged at byte {}: {}", path_, index_, begin, error.what()));
    }
    if (line.status == ByteReader::LineStatus::too_long)
      throw IoError(fmt::format("{}: frame {} is damaged at byte {}: its line is longer than the allowed {} bytes",
                                path_, index_, begin, y4m_max_line));
    throw IoError(fmt::format("{}: frame {} is cut off within its line: all of its {} bytes are missing", path_, index_,
                              header_.luma_bytes + header_.chroma_bytes));
  }

  std::optional<BufferPool::Lease> take_buffer() {
    try {
      return pool_->acquire(header_.luma_bytes);
    } catch (const std::bad_alloc&) {
      throw IoError(fmt::format("{}: no memory for frames of {}x{} pixels, {} bits", path_, header_.width,
                                header_.height, header_.bits));
    }
  }

  [[nodiscard]] FrameInfo info_of_frame(const Y4mFrameLine& line) const {
    FrameInfo info;
    info.arrival_ns = monotonic_now_ns();
    info.sequence = index_;
    info.order = header_.mixed ? line.order.value_or(FieldOrder::unknown) : header_.order;
    if (const Ratio& rate = header_.frame_rate; rate.known()) {
      // Whole seconds apart, so that no product overflows: both parts of the rate fit into 31 bits.
      const auto numerator = static_cast<std::uint64_t>(rate.numerator);
      const auto denominator = static_cast<std::uint64_t>(rate.denominator);
      constexpr std::uint64_t second = 1'000'000'000;
      const std::uint64_t periods = index_ / numerator;
      const std::uint64_t rest = index_ % numerator * denominator;
      info.timestamp_ns = static_cast<std::int64_t>((periods * denominator + rest / numerator) * second +
                                                    rest % numerator * second / numerator);
      info.clock = Clock::recording;
    }
    if (line.tag) {
      info.sequence = line.tag->sequence;
      info.timestamp_ns = line.tag->timestamp_ns;
      info.clock = line.tag->clock;
      info.stamped_at = line.tag->stamped_at;
      info.field = line.tag->field;
      info.order = line.tag->order;
      info.status = line.tag->status;
    }
    return info;
  }

  [[nodiscard]] IoError cut_off(std::uint64_t missing) const {
    return IoError(fmt::format("{}: frame {} is cut off: {} of its {} bytes are missing", path_, index_, missing,
                               header_.luma_bytes + header_.chroma_bytes));
  }

  void swap_bytes(std::byte* data) const {
    if (header_.bits <= 8) return;
    for (std::size_t i = 0; i + 1 < header_.luma_bytes; i += 2) std::swap(data[i], data[i + 1]);
  }

  std::string path_;
  ByteReader reader_;
  Y4mHeader header_;
  SourceInfo info_;
  std::shared_ptr<BufferPool> pool_;
  std::uint64_t index_ = 0;
  bool ended_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> open_y4m(const std::string& path) { return std::make_unique<Y4mSource>(path); }

}  // namespace vsfind
