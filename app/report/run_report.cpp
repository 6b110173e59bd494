#include "app/report/run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "app/drawing.h"
#include "app/overlay.h"
#include "app/report/chart.h"
#include "app/report/page.h"
#include "app/result_row.h"

namespace vsfind {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t most_samples = 20000;  // of a pattern; a chart has a thousand columns
constexpr std::size_t most_failures = 18;
constexpr std::size_t most_weakest = 6;
constexpr std::size_t most_bad_frames = 100;

}  // namespace

RunReport::RunReport(std::string folder, std::vector<std::shared_ptr<const Pattern>> patterns)
    : folder_(std::move(folder)), patterns_(std::move(patterns)), samples_(patterns_.size()) {
  make_report_folder(folder_);
}

void RunReport::thin_out() {
  for (auto& samples : samples_) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < samples.size(); i += 2) samples[kept++] = samples[i];
    samples.resize(kept);
  }
  stride_ *= 2;
}

void RunReport::add(const FrameResult& result, const SourceMapping& mapping, double latency_ms) {
  source_ = result.source;
  unit_ = mapping.unit;
  const std::uint64_t frame = result.info.sequence;
  if (frames_ > 0 && frame > last_frame_ + 1) gaps_ += frame - last_frame_ - 1;
  last_frame_ = frame;
  const bool charted = frames_ % stride_ == 0;
  ++frames_;
  if (result.info.status != FrameStatus::good && bad_frames_.size() < most_bad_frames) bad_frames_.push_back(frame);
  for (std::size_t i = 0; i < result.pictures.size(); ++i) {
    const PictureResult& picture = result.pictures[i];
    for (std::size_t p = 0; p < picture.patterns.size() && charted; ++p) {
      Sample sample;
      sample.frame = static_cast<double>(frame) + 0.5 * static_cast<double>(i);
      sample.score = sample.x = sample.y = sample.angle_deg = nothing;
      sample.search_ms = picture.search_ms;
      sample.latency_ms = latency_ms;
      if (const auto& matches = picture.patterns[p].matches; !matches.empty()) {
        const Match& best = matches.front();
        sample.score = best.score;
        sample.x = best.pose.x;
        sample.y = best.pose.y;
        sample.angle_deg = best.pose.angle_deg;
      }
      samples_[p].push_back(sample);
    }
    keep_shot(result, picture, mapping);
  }
  if (!samples_.empty() && samples_[0].size() > most_samples) thin_out();
}

void RunReport::keep_shot(const FrameResult& result, const PictureResult& picture, const SourceMapping& mapping) {
  double lowest = 2.0;
  bool failed = false;
  for (const auto& pattern : picture.patterns) {
    failed = failed || pattern.matches.empty();
    if (!pattern.matches.empty()) lowest = std::min(lowest, pattern.matches.front().score);
  }
  if (failed) ++failed_pictures_;
  const bool wanted =
      failed ? failures_.size() < most_failures : weakest_.size() < most_weakest || lowest < weakest_.back().score;
  if (!wanted || picture.grey.pixels.empty()) return;
  Shot shot;
  shot.score = lowest;
  shot.caption =
      fmt::format("frame {}{}", result.info.sequence,
                  picture.field == Field::frame ? std::string{} : fmt::format(", {} field", name(picture.field)));
  if (!failed) shot.caption += fmt::format(", score {}", fixed(lowest, 4));
  shot.picture = overlay_canvas(picture.grey, picture.field);
  draw_matches(shot.picture, picture, patterns_, mapping.mapping);
  shot.picture = for_gallery(shot.picture);
  if (failed) {
    failures_.push_back(std::move(shot));
    return;
  }
  const auto place = std::upper_bound(weakest_.begin(), weakest_.end(), lowest,
                                      [](double score, const Shot& other) { return score < other.score; });
  weakest_.insert(place, std::move(shot));
  if (weakest_.size() > most_weakest) weakest_.pop_back();
}

void RunReport::write(const Summary& summary) const {
  Page page("vsfind: " + source_);
  page.key_figures({{fmt::format("{}", summary.frames), "frames"},
                    {fmt::format("{}", summary.found), "instances found"},
                    {fmt::format("{}", summary.not_found), "not found"},
                    {fmt::format("{}", summary.bad), "bad frames"},
                    {fmt::format("{}", gaps_), "lost by the source"},
                    {fmt::format("{}", summary.dropped), "dropped: the search did not keep up"},
                    {fixed(summary.search_ms.quantile(0.5), 2) + " ms", "search time, median"},
                    {fixed(summary.search_ms.quantile(0.99), 2) + " ms", "99th percentile"}});
  if (stride_ > 1) page.paragraph(fmt::format("The charts show every {}th frame; the counts are of all.", stride_));

  const auto add_chart = [&](const std::string& file, const Chart& chart, const std::string& caption) {
    const cv::Mat picture = draw_chart(chart);
    write_png(folder_ + "/" + file + ".png", picture);
    page.chart(picture, chart.title + ". " + caption);
  };
  const auto over_time = [&](const std::string& file, const std::string& title, const std::string& y_label,
                             auto value) {
    Chart chart;
    chart.title = title;
    chart.x_label = "frame";
    chart.y_label = y_label;
    chart.whole_steps = true;
    for (std::size_t p = 0; p < patterns_.size(); ++p) {
      Curve curve;
      curve.name = patterns_[p]->name;
      curve.colour = chart_colour(p);
      curve.markers = samples_[p].size() <= 120;
      for (const auto& sample : samples_[p]) {
        curve.x.push_back(sample.frame);
        curve.y.push_back(value(sample));
      }
      chart.curves.push_back(std::move(curve));
    }
    add_chart(file, chart, "The best instance in each picture; a gap is a picture in which it was not found.");
  };
  page.heading("Over time");
  over_time("score", "Score", "normalized correlation", [](const Sample& s) { return s.score; });
  over_time("x", "Position x", unit_, [](const Sample& s) { return s.x; });
  over_time("y", "Position y", unit_, [](const Sample& s) { return s.y; });
  over_time("angle", "Angle", "degrees", [](const Sample& s) { return s.angle_deg; });
  page.heading("Times");
  const auto times = [&](const std::string& file, const std::string& title, const std::string& caption, auto value) {
    std::vector<double> values;
    if (!samples_.empty()) {
      for (const auto& sample : samples_[0]) values.push_back(value(sample));
    }
    Chart chart = histogram_of(values, 40, 0.995);
    chart.title = title;
    chart.x_label = "milliseconds";
    chart.y_label = "pictures";
    add_chart(file, chart, caption);
  };
  times("latency", "Latency", "From the frame's arrival to its result; the slowest 0.5% are in the last bar.",
        [](const Sample& s) { return s.latency_ms; });
  times("search", "Search time", "Pyramid to pose, for all patterns; the slowest 0.5% are in the last bar.",
        [](const Sample& s) { return s.search_ms; });

  page.heading("Failures");
  if (failed_pictures_ == 0) page.paragraph("Every pattern was found in every picture that was searched.");
  if (failed_pictures_ > 0) {
    page.paragraph(fmt::format("A pattern was not found in {} pictures; the first {} are shown.", failed_pictures_,
                               failures_.size()));
  }
  if (!bad_frames_.empty()) {
    page.paragraph(fmt::format("Bad frames, never searched: {}{}.", fmt::join(bad_frames_, ", "),
                               summary.bad > bad_frames_.size() ? ", ..." : ""));
  }
  for (const auto& shot : failures_) page.gallery_picture(shot.picture, shot.caption);
  if (!weakest_.empty()) page.heading("Weakest matches");
  for (const auto& shot : weakest_) page.gallery_picture(shot.picture, shot.caption);
  page.write(folder_ + "/report.html");
}

}  // namespace vsfind
