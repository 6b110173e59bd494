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

StageRunner::StageRunner(const SourceInfo& source, StageRequest request)
    : request_(std::move(request)), finder_({request_.pattern}, request_.search) {
  run_.pattern = request_.pattern;
  run_.source = source.name;
  run_.unit = request_.mapping.unit;
  run_.width = source.width;
  run_.height = source.height;
  const Range angles = request_.search.angle_deg.value_or(request_.pattern->angle_deg);
  run_.angle_searched = angles.searched();
}

void StageRunner::add(const Frame& frame) {
  const FrameInfo& info = frame.info();
  // A frame that the source lost was a step all the same; both fields of a frame have its number.
  if (any_) step_ += std::max(1.0, static_cast<double>(info.sequence) - static_cast<double>(last_));
  any_ = true;
  last_ = info.sequence;
  if (info.status != FrameStatus::good) {
    ++run_.bad_frames;
    return;
  }
  request_.mapping.check_size(frame.image().width, frame.image().height, info.field);
  const bool whole = info.field == Field::frame;
  const Field field = whole ? request_.field : info.field;
  const ImageView image = whole ? field_view(frame.image(), field) : frame.image();
  const Mapping mapping = request_.mapping.mapping.for_field(field);
  run_.field = field;

  StageFrame& now = run_.frames.emplace_back();
  now.frame = info.sequence;
  now.step = step_;
  const auto& matches = finder_.find(image, mapping).front().matches;
  now.search_ms = finder_.search_ms();
  if (!matches.empty()) now.match = matches.front();
  if (run_.frames.size() <= request_.truth.size()) now.truth = request_.truth[run_.frames.size() - 1];
  now.noise = image_noise(image);
  noise_sum_ += now.noise;

  if (request_.fiducials.wanted && !tracker_) {
    std::vector<RoughSquare> start;
    if (!request_.fiducials.regions.empty()) {
      start = squares_in(request_.fiducials.regions, image, mapping, run_.source);
    } else if (now.match) {
      start = squares_around(*now.match, *request_.pattern, image, mapping);
    }
    if (!start.empty()) tracker_.emplace(std::move(start));
  }
  if (tracker_) now.fiducials = tracker_->measure(image, mapping);
  if (run_.picture.pixels.empty() || (run_.squares.empty() && now.fiducials)) {
    run_.picture = grey_picture(image);
    run_.picture_match = now.match;
    if (now.fiducials) run_.squares = tracker_->squares();
  }
  if (now.match) bound_.add(image, mapping, *request_.pattern, now.match->pose, now.noise);
}

StageRun StageRunner::finish() {
  if (!run_.frames.empty()) run_.noise = noise_sum_ / static_cast<double>(run_.frames.size());
  run_.bound = bound_.bound(run_.angle_searched);
  return std::move(run_);
}

std::vector<StageRun> run_stage(FrameSource& source, const std::vector<StageRequest>& requests,
                                std::size_t most_frames) {
  std::vector<StageRunner> runners;
  runners.reserve(requests.size());
  for (const auto& request : requests) runners.emplace_back(source.info(), request);
  std::size_t good = 0;
  while (most_frames == 0 || good < most_frames) {
    const auto frame = source.next();
    if (!frame) break;
    if (frame->info().status == FrameStatus::good) ++good;
    for (auto& runner : runners) runner.add(*frame);
  }
  std::vector<StageRun> runs;
  runs.reserve(runners.size());
  for (auto& runner : runners) runs.push_back(runner.finish());
  return runs;
}

}  // namespace vsfind
