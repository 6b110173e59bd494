#include "app/qualify/stage_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "acquisition/errors.h"
#include "app/qualify/image_noise.h"

namespace vsfind {
namespace {

std::vector<RoughSquare> squares_in(const std::vector<Roi>& regions, const ImageView& image, const Mapping& mapping,
                                    const std::string& source) {
  std::vector<RoughSquare> chosen;
  for (const Roi& region : regions) {
    const auto found = find_squares(image, mapping, region);
    if (found.empty()) {
      throw UsageError(
          fmt::format("--fiducials {},{},{},{}: there is no square in that region of the first frame of {} "
                      "(allowed: a region with one whole square, dark or light, of 10 pixels or more)",
                      region.x, region.y, region.width, region.height, source));
    }
    chosen.push_back(found.front());
  }
  return chosen;
}

std::vector<RoughSquare> squares_around(const Match& match, const Pattern& pattern, const ImageView& image,
                                        const Mapping& mapping) {
  // Half the pattern's smaller side, in pixels of the picture: squares whose centre is nearer are its own.
  const Eigen::Vector2d origin(match.pose.x, match.pose.y);
  const Eigen::Vector2d middle = plane_from_pattern(
      match.pose,
      pattern.pitch * Eigen::Vector2d(pattern.left + pattern.width / 2.0, pattern.top + pattern.height / 2.0));
  const Eigen::Vector2d place = mapping.image_from_plane(middle);
  const double pixels = mapping.image_from_plane_jacobian(origin).norm() / std::sqrt(2.0);
  const double clear = 0.5 * std::min(pattern.width, pattern.height) * pattern.pitch * pixels;
  return four_around(find_squares(image, mapping, {0, 0, image.width, image.height}), place, clear);
}

}  // namespace

StageRun run_stage(FrameSource& source, const StageRequest& request) {
  Finder finder({request.pattern}, request.search);
  StageRun run;
  run.pattern = request.pattern;
  run.source = source.info().name;
  run.unit = request.mapping.unit;
  run.width = source.info().width;
  run.height = source.info().height;
  const Range angles = request.search.angle_deg.value_or(request.pattern->angle_deg);
  run.angle_searched = angles.searched();
  std::optional<FiducialTracker> tracker;
  PoseBoundEstimator bound;
  double noise_sum = 0.0;
  while (const auto frame = source.next()) {
    if (request.most_frames > 0 && run.frames.size() >= request.most_frames) break;
    if (frame->info().status != FrameStatus::good) {
      ++run.bad_frames;
      continue;
    }
    request.mapping.check_size(frame->image().width, frame->image().height, frame->info().field);
    const bool whole = frame->info().field == Field::frame;
    const Field field = whole ? request.field : frame->info().field;
    const ImageView image = whole ? field_view(frame->image(), field) : frame->image();
    const Mapping mapping = request.mapping.mapping.for_field(field);
    run.field = field;

    StageFrame& now = run.frames.emplace_back();
    now.frame = frame->info().sequence;
    const auto& matches = finder.find(image, mapping).front().matches;
    now.search_ms = finder.search_ms();
    if (!matches.empty()) now.match = matches.front();
    if (run.frames.size() <= request.truth.size()) now.truth = request.truth[run.frames.size() - 1];
    now.noise = image_noise(image);
    noise_sum += now.noise;

    if (request.fiducials.wanted && !tracker) {
      std::vector<RoughSquare> start;
      if (!request.fiducials.regions.empty()) {
        start = squares_in(request.fiducials.regions, image, mapping, run.source);
      } else if (now.match) {
        start = squares_around(*now.match, *request.pattern, image, mapping);
      }
      if (!start.empty()) tracker.emplace(std::move(start));
    }
    if (tracker) now.fiducials = tracker->measure(image, mapping);
    if (run.picture.pixels.empty() || (run.squares.empty() && now.fiducials)) {
      run.picture = grey_picture(image);
      run.picture_match = now.match;
      if (now.fiducials) run.squares = tracker->squares();
    }
    if (now.match) bound.add(image, mapping, *request.pattern, now.match->pose, now.noise);
  }
  if (!run.frames.empty()) run.noise = noise_sum / static_cast<double>(run.frames.size());
  run.bound = bound.bound(run.angle_searched);
  return run;
}

}  // namespace vsfind
