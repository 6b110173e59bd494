#include "acquisition/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/byte_reader.h"
#include "acquisition/errors.h"
#include "acquisition/image_probe.h"
#include "acquisition/jpeg_luma.h"

namespace vsfind {
namespace {

// Of a pipe or a device, whose end is not known, less is taken before it is given up.
constexpr std::size_t max_file_bytes = std::size_t{1} << 31U;
constexpr std::size_t max_stream_bytes = std::size_t{1} << 28U;

/// The whole file, read in steps so that a device or pipe without end is noticed.
std::vector<std::byte> read_file(const std::string& path) {
  ByteReader reader(path);
  std::vector<std::byte> bytes;
  const std::optional<std::uint64_t> size = reader.remaining();
  const std::size_t limit = size ? max_file_bytes : max_stream_bytes;
  std::size_t step = static_cast<std::size_t>(size.value_or(0)) + 4096;
  for (;;) {
    if (bytes.size() + step > limit)
      throw IoError(fmt::format("{}: is too large for an image: at most {} bytes are allowed", path, limit));
    const std::size_t before = bytes.size();
    bytes.resize(before + step);
    const std::size_t count = reader.read(bytes.data() + before, step);
    bytes.resize(before + count);
    if (count < step) return bytes;
    step = bytes.size();
  }
}

/// Mono, 8 or 16 bits. Throws cv::Exception, or IoError without a file name.
cv::Mat decode(const std::vector<std::byte>& bytes) {
  const cv::Mat input(1, static_cast<int>(bytes.size()), CV_8U, const_cast<std::byte*>(bytes.data()));
  cv::Mat decoded = cv::imdecode(input, cv::IMREAD_UNCHANGED);
  if (decoded.empty()) throw IoError("is damaged: it cannot be decoded");
  if (decoded.depth() != CV_8U && decoded.depth() != CV_16U)
    throw IoError("has pixels of neither 8 nor 16 bits: no others are allowed");
  if (decoded.channels() == 1) return decoded;
  cv::Mat luma;
  if (decoded.channels() == 3) {
    cv::cvtColor(decoded, luma, cv::COLOR_BGR2GRAY);
  } else if (decoded.channels() == 4) {
    cv::cvtColor(decoded, luma, cv::COLOR_BGRA2GRAY);
  } else {
    cv::extractChannel(decoded, luma, 0);  // grey and alpha
  }
  return luma;
}

cv::Mat decode(const std::vector<std::byte>& bytes, const ImageProbe& probe) {
  if (probe.format == ImageFormat::png) return decode(png_pixels_only(bytes));
  if (probe.format != ImageFormat::jpeg) return decode(bytes);
  cv::Mat luma(static_cast<int>(probe.height), static_cast<int>(probe.width), CV_8U);
  decode_jpeg_luma(bytes, luma.data, luma.cols, luma.rows);
  return luma;
}

Image decode_checked(const std::vector<std::byte>& bytes) {
  const ImageProbe probe = probe_image(bytes);
  if (probe.width > image_max_side || probe.height > image_max_side || probe.width * probe.height > image_max_pixels)
    throw IoError(fmt::format("has {}x{} pixels: allowed are {} either way and {} together", probe.width, probe.height,
                              image_max_side, image_max_pixels));
  const auto mat = std::make_shared<const cv::Mat>(decode(bytes, probe));
  ImageView view;
  view.data = reinterpret_cast<const std::byte*>(mat->data);
  view.width = mat->cols;
  view.height = mat->rows;
  view.stride = static_cast<std::ptrdiff_t>(mat->step[0]);
  view.bits = mat->depth() == CV_8U ? 8 : 16;
  const bool whole_bits = std::has_single_bit(static_cast<unsigned>(probe.maximum) + 1U);
  if (view.bits == 16 && probe.maximum > 255 && whole_bits)
    view.bits = static_cast<int>(std::bit_width(static_cast<unsigned>(probe.maximum)));
  return {std::shared_ptr<const std::byte>(mat, view.data), view};
}

}  // namespace

Image load_image(const std::string& path) {
  // OpenCV writes its own lines for what it cannot read; the user gets ours.
  [[maybe_unused]] static const auto silenced = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  try {
    const std::vector<std::byte> bytes = read_file(path);
    try {
      return decode_checked(bytes);
    } catch (const IoError& error) {
      throw IoError(fmt::format("{}: {}", path, error.what()));
    }
  } catch (const cv::Exception&) {  // its text has several lines and names sources of OpenCV
    throw IoError(fmt::format("{}: is damaged: it cannot be decoded", path));
  } catch (const std::bad_alloc&) {
    throw IoError(fmt::format("{}: there is no memory for an image of this size", path));
  }
}

bool has_image_ending(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos || name.find(' ', dot) != std::string_view::npos) return false;
  std::string ending(name.substr(dot));
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return (std::string(image_endings) + ' ').find(ending + ' ') != std::string::npos;
}

}  // namespace vsfind
