#include "acquisition/v4l2_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace vsfind {
namespace {

// Of rectangles, also where several planes are captured.
constexpr std::uint32_t capture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
constexpr double rate_tolerance = 0.02;  // 29.97 will do for 30

/// The smaller, the better: luma as it stands in one byte, then beside colour, then in two bytes, then what must be
/// decoded, then what must be converted.
int cost_of(std::uint32_t fourcc) {
  const auto layout = luma_layout(fourcc);
  if (!layout) return is_jpeg(fourcc) ? 4 : 5;
  if (layout->bits > 8) return 3;
  return layout->step > 1 ? 2 : layout->rows_numerator > layout->rows_denominator ? 1 : 0;
}

/// What libv4l2 converts lies in one memory.
bool can_be_read(const V4l2Format& format) { return format.memories <= 1 || luma_layout(format.pix.pixelformat); }

bool offers(const V4l2Device& device, std::uint32_t fourcc, const CameraSettings& settings, V4l2Format format) {
  v4l2_pix_format& pix = format.pix;
  pix.pixelformat = fourcc;
  pix.bytesperline = 0;
  const v4l2_pix_format wanted = pix;
  if (device.call_format(VIDIOC_TRY_FMT, format) != 0 || pix.pixelformat != fourcc || !can_be_read(format))
    return false;
  if (settings.width > 0 && (pix.width != wanted.width || pix.height != wanted.height)) return false;
  if (settings.frame_rate <= 0) return true;
  bool is_range = false;
  const auto rates = frame_rates(device, fourcc, pix.width, pix.height, is_range);
  return rates.empty() || rates.front() >= settings.frame_rate * (1 - rate_tolerance);
}

/// `format` holds size and field order as they will be asked for.
std::uint32_t choose_format(const V4l2Device& device, const CameraSettings& settings, const V4l2Format& format) {
  const auto formats = pixel_formats(device);
  if (!settings.pixel_format.empty()) {
    std::string allowed;
    for (const v4l2_fmtdesc& known : formats) {
      const std::string name = fourcc_name(known.pixelformat);
      if (name == settings.pixel_format) return known.pixelformat;
      allowed += (allowed.empty() ? "" : ", ") + name;
    }
    // Drivers may take more than they list; set_picture() sees whether they do.
    if (formats.empty()) {
      if (const auto fourcc = fourcc_from_name(settings.pixel_format)) return *fourcc;
    }
    throw UsageError(
        fmt::format("{}: has no pixel format '{}' (allowed: {})", device.name(), settings.pixel_format, allowed));
  }
  std::vector<std::uint32_t> candidates;
  candidates.reserve(formats.size());
  for (const v4l2_fmtdesc& known : formats) candidates.push_back(known.pixelformat);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](std::uint32_t a, std::uint32_t b) { return cost_of(a) < cost_of(b); });
  for (const std::uint32_t fourcc : candidates) {
    if (offers(device, fourcc, settings, format)) return fourcc;
  }
  return candidates.empty() ? format.pix.pixelformat : candidates.front();
}

v4l2_selection selection(std::uint32_t target) {
  v4l2_selection result{};
  result.type = capture;
  result.target = target;
  return result;
}

/// The part of the sensor that is read out: as asked, or else all of it, whatever an earlier program left.
void set_crop(const V4l2Device& device, const CameraSettings& settings) {
  v4l2_selection crop = selection(V4L2_SEL_TGT_CROP);
  v4l2_selection whole = selection(V4L2_SEL_TGT_CROP_DEFAULT);
  const bool wanted = settings.offset_x || settings.offset_y;
  if (device.call(VIDIOC_G_SELECTION, &whole) != 0) {
    if (wanted)
      throw UsageError(fmt::format("{}: cannot read out a part of its picture: no offset is allowed", device.name()));
    return;
  }
  crop.r = whole.r;
  if (wanted) {
    const int left = settings.offset_x.value_or(0);
    const int top = settings.offset_y.value_or(0);
    crop.r.left = whole.r.left + left;
    crop.r.top = whole.r.top + top;
    crop.r.width = settings.width > 0 ? static_cast<std::uint32_t>(settings.width)
                                      : whole.r.width - std::min(whole.r.width, static_cast<std::uint32_t>(left));
    crop.r.height = settings.height > 0 ? static_cast<std::uint32_t>(settings.height)
                                        : whole.r.height - std::min(whole.r.height, static_cast<std::uint32_t>(top));
  }
  const v4l2_rect asked = crop.r;
  const int error = device.call(VIDIOC_S_SELECTION, &crop);
  if (!wanted) return;  // best effort
  if (error != 0 || crop.r.left != asked.left || crop.r.top != asked.top || crop.r.width != asked.width ||
      crop.r.height != asked.height)
    throw UsageError(
        fmt::format("{}: cannot read out {}x{} pixels from {},{} of its {}x{}{}", device.name(), asked.width,
                    asked.height, asked.left - whole.r.left, asked.top - whole.r.top, whole.r.width, whole.r.height,
                    error != 0 ? std::string()
                               : fmt::format(" (the nearest is {}x{} from {},{})", crop.r.width, crop.r.height,
                                             crop.r.left - whole.r.left, crop.r.top - whole.r.top)));
}

/// The size of the whole picture of an analogue input.
void default_size(const V4l2Device& device, const V4l2Input& input, v4l2_pix_format& format) {
  v4l2_selection whole = selection(V4L2_SEL_TGT_CROP_DEFAULT);
  if (device.call(VIDIOC_G_SELECTION, &whole) == 0 && whole.r.width > 0 && whole.r.height > 0) {
    format.width = whole.r.width;
    format.height = whole.r.height;
  } else {
    format.height = static_cast<std::uint32_t>(input.standard_lines);
  }
}

void set_format(const V4l2Device& device, const V4l2Input& input, const CameraSettings& settings,
                V4l2Picture& picture) {
  V4l2Format& format = picture.format;
  device.require_format(VIDIOC_G_FMT, format, "does not tell its format");
  const auto current = static_cast<BufferFields>(format.pix.field);
  const bool analogue = input.standard != 0;
  BufferFields wanted = BufferFields::any;
  if (!settings.field_order.empty()) {
    try {
      wanted = parse_buffer_fields(settings.field_order);
    } catch (const UsageError& error) {
      throw UsageError(fmt::format("{}: {}", device.name(), error.what()));
    }
  }
  const BufferFields asked = wanted == BufferFields::any && analogue ? BufferFields::interlaced : wanted;
  v4l2_pix_format& pix = format.pix;
  // Rows of a whole frame, until they are asked for.
  pix.height = static_cast<std::uint32_t>(frame_rows(current, static_cast<int>(pix.height)));
  if (settings.width > 0) {
    pix.width = static_cast<std::uint32_t>(settings.width);
    pix.height = static_cast<std::uint32_t>(settings.height);
  } else if (analogue) {
    default_size(device, input, pix);
  } else if (input.timings.width > 0) {
    pix.width = input.timings.width;
    pix.height = input.timings.height;
  }
  pix.height = static_cast<std::uint32_t>(buffer_rows(asked, static_cast<int>(pix.height)));
  pix.field = static_cast<std::uint32_t>(asked);
  pix.pixelformat = choose_format(device, settings, format);
  pix.bytesperline = 0;  // for the driver to say
  pix.sizeimage = 0;
  const v4l2_pix_format request = pix;
  device.require_format(VIDIOC_S_FMT, format, "does not take a format");

  picture.fields = static_cast<BufferFields>(pix.field);
  const auto got = [&] {
    return fmt::format("{}x{} {} {}", pix.width, frame_rows(picture.fields, static_cast<int>(pix.height)),
                       fourcc_name(pix.pixelformat), name(picture.fields));
  };
  if (pix.pixelformat != request.pixelformat)
    throw UsageError(fmt::format("{}: does not take the pixel format '{}' (it gives {})", device.name(),
                                 fourcc_name(request.pixelformat), got()));
  if (!can_be_read(format))
    throw UsageError(fmt::format("{}: luma cannot be had from the pixel format '{}', whose {} planes lie apart",
                                 device.name(), fourcc_name(pix.pixelformat), format.memories));
  const bool fields_as_asked = wanted == BufferFields::any || picture.fields == wanted ||
                               (wanted == BufferFields::interlaced && (picture.fields == BufferFields::interlaced_tb ||
                                                                       picture.fields == BufferFields::interlaced_bt));
  if (!fields_as_asked)
    throw UsageError(fmt::format("{}: does not take the field order '{}'{} (it gives {})", device.name(), name(wanted),
                                 input.name.empty() ? "" : fmt::format(" at input '{}'", input.name), got()));
  if (settings.width > 0 && (pix.width != request.width || frame_rows(picture.fields, static_cast<int>(pix.height)) !=
                                                               frame_rows(asked, static_cast<int>(request.height))))
    throw UsageError(fmt::format("{}: does not take the size {}x{} (it gives {})", device.name(), settings.width,
                                 settings.height, got()));
  if (pix.width == 0 || pix.height == 0) throw CameraError(fmt::format("{}: its pictures have no size", device.name()));
}

/// Fills the buffer with the picture: a rectangle that an earlier program left survives a change of the format.
void set_compose(const V4l2Device& device, const v4l2_pix_format& pix) {
  v4l2_selection compose = selection(V4L2_SEL_TGT_COMPOSE);
  if (device.call(VIDIOC_G_SELECTION, &compose) != 0) return;
  compose.r = {0, 0, pix.width, pix.height};
  static_cast<void>(device.call(VIDIOC_S_SELECTION, &compose));
}

Ratio reduced(std::int64_t numerator, std::int64_t denominator) {
  const std::int64_t common = std::gcd(numerator, denominator);
  return common > 0 ? Ratio{numerator / common, denominator / common} : Ratio{};
}

Ratio read_pixel_aspect(const V4l2Device& device, const V4l2Picture& picture) {
  v4l2_cropcap cropcap{};
  cropcap.type = capture;
  Ratio aspect{1, 1};  // webcams do not answer
  // The driver's fraction is height : width.
  if (device.call(VIDIOC_CROPCAP, &cropcap) == 0 && cropcap.pixelaspect.numerator > 0 &&
      cropcap.pixelaspect.denominator > 0)
    aspect = reduced(cropcap.pixelaspect.denominator, cropcap.pixelaspect.numerator);
  v4l2_selection crop = selection(V4L2_SEL_TGT_CROP);
  v4l2_selection compose = selection(V4L2_SEL_TGT_COMPOSE);
  if (device.call(VIDIOC_G_SELECTION, &crop) != 0 || device.call(VIDIOC_G_SELECTION, &compose) != 0) return aspect;
  if (crop.r.width == 0 || crop.r.height == 0 || compose.r.width == 0 || compose.r.height == 0) return aspect;
  // Where the device scales its picture, a pixel covers more or less of it.
  const std::int64_t rows = frame_rows(picture.fields, static_cast<int>(compose.r.height));
  const Ratio across = reduced(crop.r.width, compose.r.width);
  const Ratio down = reduced(crop.r.height, rows);
  return reduced(aspect.numerator * across.numerator * down.denominator,
                 aspect.denominator * across.denominator * down.numerator);
}

Ratio set_frame_rate(const V4l2Device& device, const V4l2Input& input, const CameraSettings& settings,
                     const v4l2_pix_format& pix) {
  v4l2_streamparm parameters{};
  parameters.type = device.stream_type();
  const bool known = device.call(VIDIOC_G_PARM, &parameters) == 0;
  const v4l2_fract& period = parameters.parm.capture.timeperframe;
  const auto rate = [&] { return known ? reduced(period.denominator, period.numerator) : Ratio{}; };
  if (settings.frame_rate > 0) {
    const auto close = [&] {
      return rate().known() && std::abs(rate().value() - settings.frame_rate) <= rate_tolerance * settings.frame_rate;
    };
    if (known && (parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0) {
      constexpr std::uint32_t thousands = 1000;
      parameters.parm.capture.timeperframe = {thousands,
                                              static_cast<std::uint32_t>(std::lround(settings.frame_rate * thousands))};
      device.require(VIDIOC_S_PARM, &parameters, "does not take a frame rate");
    }
    if (!close()) {
      bool is_range = false;
      std::string allowed;
      for (const double offered : frame_rates(device, pix.pixelformat, pix.width, pix.height, is_range))
        allowed += fmt::format("{}{:.6g}", allowed.empty() ? "" : is_range ? " to " : ", ", offered);
      if (allowed.empty()) allowed = rate().known() ? fmt::format("{:.6g}", rate().value()) : "none";
      throw UsageError(fmt::format("{}: does not give {:.6g} frames per second at {}x{} {} (allowed: {})",
                                   device.name(), settings.frame_rate, pix.width, pix.height,
                                   fourcc_name(pix.pixelformat), allowed));
    }
  }
  return rate().known() ? rate() : reduced(input.frame_rate.numerator, input.frame_rate.denominator);
}

}  // namespace

std::vector<v4l2_fmtdesc> pixel_formats(const V4l2Device& device) {
  std::vector<v4l2_fmtdesc> formats;
  v4l2_fmtdesc format{};
  format.type = device.stream_type();
  while (device.call(VIDIOC_ENUM_FMT, &format) == 0) {
    formats.push_back(format);
    const std::uint32_t index = format.index + 1;
    format = {};
    format.type = device.stream_type();
    format.index = index;
  }
  return formats;
}

std::vector<double> frame_rates(const V4l2Device& device, std::uint32_t fourcc, std::uint32_t width,
                                std::uint32_t height, bool& is_range) {
  std::vector<double> rates;
  is_range = false;
  const auto add = [&rates](const v4l2_fract& period) {
    if (period.numerator > 0 && period.denominator > 0)
      rates.push_back(static_cast<double>(period.denominator) / period.numerator);
  };
  v4l2_frmivalenum interval{};
  interval.pixel_format = fourcc;
  interval.width = width;
  interval.height = height;
  while (device.call(VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0) {
    if (interval.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      add(interval.discrete);
    } else {
      is_range = true;
      add(interval.stepwise.min);
      add(interval.stepwise.max);
      break;
    }
    const std::uint32_t index = interval.index + 1;
    interval = {};
    interval.index = index;
    interval.pixel_format = fourcc;
    interval.width = width;
    interval.height = height;
  }
  std::sort(rates.begin(), rates.end(), std::greater<>());
  return rates;
}

V4l2Picture set_picture(const V4l2Device& device, const V4l2Input& input, const CameraSettings& settings) {
  V4l2Picture picture;
  set_crop(device, settings);
  set_format(device, input, settings, picture);
  set_compose(device, picture.format.pix);
  picture.frame_rate = set_frame_rate(device, input, settings, picture.format.pix);
  // Again: what came after it may have changed the lines' length.
  device.require_format(VIDIOC_G_FMT, picture.format, "does not tell its format");
  picture.pixel_aspect = read_pixel_aspect(device, picture);
  return picture;
}

}  // namespace vsfind
