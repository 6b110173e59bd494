#include <fmt/format.h>

#include <utility>

#include "acquisition/camera.h"
#include "acquisition/errors.h"
#ifdef VSFIND_HAVE_ARAVIS
#include "acquisition/gige_source.h"
#endif
#ifdef VSFIND_HAVE_V4L2
#include "acquisition/v4l2_source.h"
#endif

namespace vsfind {
namespace {

constexpr const char* allowed = "v4l2:/dev/videoN, gige:NAME-OR-ADDRESS, gige: (the first one), file:SEQUENCE";

[[maybe_unused]] CameraError left_out(const std::string& uri, const char* kind, const char* package) {
  return CameraError(fmt::format("{}: this vsfind was built without {} cameras (Debian: install {} and build again)",
                                 uri, kind, package));
}

}  // namespace

SourceUri parse_source_uri(const std::string& uri) {
  const auto colon = uri.find(':');
  if (colon == std::string::npos)
    throw UsageError(fmt::format("'{}' is not a source's URI (allowed: {})", uri, allowed));
  const std::string scheme = uri.substr(0, colon);
  SourceUri parsed{SourceUri::Scheme::file, uri.substr(colon + 1)};
  if (scheme == "v4l2") {
    parsed.scheme = SourceUri::Scheme::v4l2;
  } else if (scheme == "gige") {
    parsed.scheme = SourceUri::Scheme::gige;
    return parsed;
  } else if (scheme != "file") {
    throw UsageError(fmt::format("'{}': the scheme '{}:' is not known (allowed: {})", uri, scheme, allowed));
  }
  if (parsed.name.empty()) throw UsageError(fmt::format("'{}': nothing follows the colon (allowed: {})", uri, allowed));
  return parsed;
}

void require_backend(const std::string& uri) {
  [[maybe_unused]] const SourceUri::Scheme scheme = parse_source_uri(uri).scheme;
#ifndef VSFIND_HAVE_V4L2
  if (scheme == SourceUri::Scheme::v4l2) throw left_out(uri, "V4L2", "libv4l-dev");
#endif
#ifndef VSFIND_HAVE_ARAVIS
  if (scheme == SourceUri::Scheme::gige) throw left_out(uri, "GigE Vision", "libaravis-dev libusb-1.0-0-dev");
#endif
}

void log_camera_libraries() {
#ifdef VSFIND_HAVE_ARAVIS
  log_gige_library();
#endif
}

std::unique_ptr<FrameSource> open_source(const std::string& uri, [[maybe_unused]] const CameraSettings& settings) {
  require_backend(uri);
  const SourceUri parsed = parse_source_uri(uri);
  switch (parsed.scheme) {
    case SourceUri::Scheme::v4l2:
#ifdef VSFIND_HAVE_V4L2
      return open_v4l2(parsed.name, settings);
#else
      break;
#endif
    case SourceUri::Scheme::gige:
#ifdef VSFIND_HAVE_ARAVIS
      return open_gige(parsed.name, settings);
#else
      break;
#endif
    case SourceUri::Scheme::file:
      break;
  }
  return open_sequence(parsed.name);
}

std::vector<CameraDescription> list_cameras() {
  std::vector<CameraDescription> cameras;
#ifdef VSFIND_HAVE_V4L2
  for (auto& camera : list_v4l2()) cameras.push_back(std::move(camera));
#endif
#ifdef VSFIND_HAVE_ARAVIS
  for (auto& camera : list_gige()) cameras.push_back(std::move(camera));
#endif
  return cameras;
}

}  // namespace vsfind
