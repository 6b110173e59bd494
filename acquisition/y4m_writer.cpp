#include <fcntl.h>
#include <fmt/format.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "acquisition/byte_reader.h"
#include "acquisition/errors.h"
#include "acquisition/recording.h"
#include "acquisition/y4m_header.h"

namespace vsfind {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what, int error) {
  throw IoError(fmt::format("{}: {}: {}", path, what, std::generic_category().message(error)));
}

Y4mHeader header_for(const std::string& path, const SourceInfo& info) {
  if (info.width < 1 || info.height < 1 || info.width > y4m_max_side || info.height > y4m_max_side ||
      static_cast<std::int64_t>(info.width) * info.height > y4m_max_pixels)
    throw UsageError(
        fmt::format("{}: frames of {}x{} pixels cannot be recorded: allowed are 1 to {} either way, {} together", path,
                    info.width, info.height, y4m_max_side, y4m_max_pixels));
  if (info.bits < 8 || info.bits > 16)
    throw UsageError(fmt::format("{}: pixels of {} bits cannot be recorded: allowed are 8 to 16", path, info.bits));
  Y4mHeader header;
  header.width = info.width;
  header.height = info.height;
  header.bits = info.bits;
  header.order = info.order;
  header.pixel_aspect = info.pixel_aspect;
  header.frame_rate = info.frame_rate;
  header.luma_bytes =
      static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height) * (info.bits > 8 ? 2U : 1U);
  return header;
}

}  // namespace

bool fit_one_recording(const SourceInfo& a, const SourceInfo& b) {
  return a.width == b.width && a.height == b.height && a.bits == b.bits && a.order == b.order &&
         a.pixel_aspect == b.pixel_aspect;
}

struct RecordingWriter::State {
  std::string path;
  Y4mHeader header;
  UniqueFd file;
  std::vector<std::byte> canvas;  // a frame as it is written, where the picture does not lie in memory like that
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0;

  [[nodiscard]] std::size_t row_bytes() const { return header.luma_bytes / static_cast<std::size_t>(header.height); }

  /// Writes a line and what follows it wholly, or fails with the file as long as before.
  void write(std::string_view line, const std::byte* data, std::size_t size) {
    std::array<iovec, 2> parts{{{const_cast<char*>(line.data()), line.size()}, {const_cast<std::byte*>(data), size}}};
    std::size_t part = 0;
    while (part < parts.size()) {
      if (parts[part].iov_len == 0) {
        ++part;
        continue;
      }
      const ssize_t count = ::writev(file.get(), parts.data() + part, static_cast<int>(parts.size() - part));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) {
        const int error = errno;
        // Best effort: a device or a pipe cannot be shortened.
        [[maybe_unused]] const int shortened = ::ftruncate(file.get(), static_cast<off_t>(bytes));
        ::lseek(file.get(), static_cast<off_t>(bytes), SEEK_SET);
        fail(path, data == nullptr ? "the header cannot be written" : fmt::format("frame {} cannot be written", frames),
             error);
      }
      auto done = static_cast<std::size_t>(count);
      for (std::size_t i = part; i < parts.size(); ++i) {
        const std::size_t step = std::min(done, parts[i].iov_len);
        parts[i].iov_base = static_cast<char*>(parts[i].iov_base) + step;
        parts[i].iov_len -= step;
        done -= step;
      }
    }
    bytes += line.size() + size;
  }

  /// The picture as the bytes of a whole frame.
  const std::byte* whole_frame(const ImageView& image, Field field) {
    const bool together = !image.empty() && field == Field::frame && image.width == header.width &&
                          image.height == header.height && image.bits == header.bits &&
                          image.stride == static_cast<std::ptrdiff_t>(row_bytes());
    if (together && (std::endian::native == std::endian::little || header.bits == 8)) return image.data;
    canvas.assign(header.luma_bytes, std::byte{0});
    if (image.empty() || (image.bits > 8) != (header.bits > 8)) return canvas.data();
    const std::size_t row = std::min(row_bytes(), static_cast<std::size_t>(image.width * image.bytes_per_pixel()));
    for (int y = 0; y < header.height; ++y) {
      const int from = field == Field::frame ? y : std::min(y / 2, field_rows(field) - 1);
      if (from < 0 || from >= image.height) continue;
      std::memcpy(canvas.data() + static_cast<std::size_t>(y) * row_bytes(), image.data + from * image.stride, row);
    }
    if constexpr (std::endian::native == std::endian::big) {
      for (std::size_t i = 0; header.bits > 8 && i + 1 < canvas.size(); i += 2) std::swap(canvas[i], canvas[i + 1]);
    }
    return canvas.data();
  }

  [[nodiscard]] int field_rows(Field field) const {
    return field == Field::frame ? header.height : field == Field::top ? (header.height + 1) / 2 : header.height / 2;
  }
};

RecordingWriter::RecordingWriter(const std::string& path, const SourceInfo& info) : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->header = header_for(path, info);
  state_->file.reset(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (state_->file.get() < 0) fail(path, "cannot be created", errno);
  state_->write(format_y4m_header(state_->header), nullptr, 0);
}

RecordingWriter::RecordingWriter(RecordingWriter&&) noexcept = default;
RecordingWriter& RecordingWriter::operator=(RecordingWriter&&) noexcept = default;
RecordingWriter::~RecordingWriter() = default;

void RecordingWriter::append(const ImageView& image, const FrameInfo& info) {
  State& state = *state_;
  if (state.file.get() < 0) throw IoError(fmt::format("{}: is closed: no frame can be added", state.path));
  const Y4mHeader& header = state.header;
  const bool fits = !image.empty() && image.width == header.width && image.height == state.field_rows(info.field) &&
                    image.bits == header.bits;
  if (info.status == FrameStatus::good && !fits)
    throw UsageError(
        fmt::format("{}: frame {} ({}) has {}x{} pixels of {} bits, the recording {}x{} of {} bits: they must agree",
                    state.path, state.frames, name(info.field), image.width, image.height, image.bits, header.width,
                    header.height, header.bits));
  Y4mTag tag;
  tag.sequence = info.sequence;
  tag.timestamp_ns = info.timestamp_ns;
  tag.clock = info.clock;
  tag.status = info.status;
  tag.field = info.field;
  tag.order = info.order;
  tag.empty = image.empty();
  tag.stamped_at = info.stamped_at;
  state.write(format_y4m_frame_line(tag), state.whole_frame(image, info.field), header.luma_bytes);
  ++state.frames;
}

void RecordingWriter::close() {
  const int fd = state_->file.release();
  // After EINTR the descriptor is gone all the same.
  if (fd >= 0 && ::close(fd) != 0 && errno != EINTR) fail(state_->path, "cannot be written", errno);
}

std::uint64_t RecordingWriter::frames() const { return state_->frames; }
std::uint64_t RecordingWriter::bytes() const { return state_->bytes; }

}  // namespace vsfind
