#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "app/drawing.h"
#include "app/evaluate/evaluation.h"
#include "app/report/chart.h"
#include "app/report/page.h"
#include "app/result_row.h"

namespace vsfind {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

double time_of(const Judgement& j) { return static_cast<double>(j.frame) + (j.field == Field::bottom ? 0.5 : 0.0); }

/// One curve over the frames; `value` gives NaN where there is none.
template <typename Value>
Curve over_frames(const std::vector<Judgement>& judgements, const std::string& curve_name, std::size_t colour,
                  Value value) {
  Curve curve;
  curve.name = curve_name;
  curve.colour = chart_colour(colour);
  curve.joined = false;
  for (const Judgement& j : judgements) {
    curve.x.push_back(time_of(j));
    curve.y.push_back(value(j));
  }
  return curve;
}

}  // namespace

void Evaluation::write_report(const std::string& folder,
                              const std::vector<std::pair<std::string, std::string>>& settings) const {
  make_report_folder(folder);
  Page page("vsfind evaluate: " + source_);
  const std::size_t right = count(Verdict::right);
  const std::size_t missed = count(Verdict::missed);
  std::vector<double> distances;
  for (const Judgement& j : judgements_) {
    if (j.verdict == Verdict::right) distances.push_back(std::hypot(j.error_x, j.error_y));
  }
  page.key_figures({{fmt::format("{} of {}", right, right + missed), "found right"},
                    {fmt::format("{}", missed), "missed"},
                    {fmt::format("{}", count(Verdict::false_alarm)), "false alarms"},
                    {fixed(spread_of(distances).rms, 4) + " " + unit_, "RMS error in position"},
                    {fixed(quantile_of(search_ms_, 0.5), 2) + " ms", "search time, median"}});
  page.heading("Counts and times");
  page.table({"", "value"}, count_table());
  page.heading("Errors of those found right");
  page.table({"error", "mean", "S.D.", "RMS", "max"}, error_table());

  const auto add_chart = [&](const std::string& file, Chart chart, const std::string& title, const std::string& x_label,
                             const std::string& y_label, const std::string& caption) {
    chart.title = title;
    chart.x_label = x_label;
    chart.y_label = y_label;
    chart.whole_steps = !chart.bars;
    const cv::Mat picture = draw_chart(chart);
    write_png(folder + "/" + file + ".png", picture);
    page.chart(picture, chart.title + ". " + caption);
  };
  const auto if_right = [](const Judgement& j, double value) { return j.verdict == Verdict::right ? value : nothing; };
  Chart position;
  position.symmetric = true;
  position.curves = {over_frames(judgements_, "x", 0, [&](const Judgement& j) { return if_right(j, j.error_x); }),
                     over_frames(judgements_, "y", 1, [&](const Judgement& j) { return if_right(j, j.error_y); })};
  add_chart("position", position, "Error in position", "frame", unit_, "Found minus true, of those found right.");
  Chart angle;
  angle.symmetric = true;
  angle.curves = {over_frames(judgements_, "", 0,
                              [&](const Judgement& j) { return if_right(j, j.error_angle_deg.value_or(nothing)); })};
  add_chart("angle", angle, "Error in angle", "frame", "degrees", "Found minus true, of those found right.");
  Chart score;
  score.curves = {over_frames(judgements_, "right", 0,
                              [&](const Judgement& j) { return j.match ? if_right(j, j.match->score) : nothing; }),
                  over_frames(judgements_, "false alarm", 1, [](const Judgement& j) {
                    return j.verdict == Verdict::false_alarm ? j.match->score : nothing;
                  })};
  add_chart("score", score, "Score", "frame", "normalized correlation",
            "A --min-score between the two tells them apart, where there is such a one.");
  add_chart("distance", histogram_of(distances, 30), "Error in position, distribution", unit_, "instances",
            "Distance of those found right.");
  add_chart("times", histogram_of(search_ms_, 40, 0.995), "Search time", "milliseconds", "pictures",
            "The slowest 0.5% are in the last bar.");

  page.heading("Worst cases");
  page.paragraph("Truth green, found red; misses and false alarms first, then the largest errors.");
  for (const auto& shot : worst_) page.gallery_picture(shot.picture, shot.caption);
  page.heading("Settings");
  std::vector<std::vector<std::string>> rows;
  rows.reserve(settings.size());
  for (const auto& [what, value] : settings) rows.push_back({what, value});
  page.table({"setting", "value"}, rows, true);
  page.write(folder + "/report.html");
}

}  // namespace vsfind
