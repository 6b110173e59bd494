#include "app/qualify/qualify_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/drawing.h"
#include "app/output_file.h"
#include "app/qualify/stage_charts.h"
#include "app/report/page.h"
#include "app/result_row.h"

namespace vsfind {
namespace {

using Table = std::vector<std::vector<std::string>>;

constexpr int place = 5;  // digits of positions and angles

/// What stands for the test's error in position: relative to the fiducials where there are any.
double position_sd(const StageAnalysis& a) {
  return a.with_fiducials > 0 ? per_axis(a.relative_x, a.relative_y) : a.pattern_across.spread.sd;
}
double position_max(const StageAnalysis& a) {
  return a.with_fiducials > 0 ? a.relative_max : a.pattern_across.spread.max;
}
double angle_sd(const StageAnalysis& a) {
  return a.with_fiducials > 0 ? a.relative_angle.spread.sd : a.pattern_turn.spread.sd;
}
double angle_max(const StageAnalysis& a) {
  return a.with_fiducials > 0 ? a.relative_angle.spread.max : a.pattern_turn.spread.max;
}
double bound_of(const PoseBound& bound) { return std::hypot(bound.x, bound.y) / std::sqrt(2.0); }

/// The closing table of one stage: header, then a row for each model.
Table closing_table(const QualifyResults& results, StageKind kind) {
  const auto test_of = [kind](const QualifyRow& row) -> const std::optional<StageTest>& {
    return kind == StageKind::linear ? row.linear : row.rotary;
  };
  const auto any =
      std::find_if(results.rows.begin(), results.rows.end(), [&](const auto& row) { return test_of(row); });
  if (any == results.rows.end()) return {};
  const StageTest& sample = *test_of(*any);
  const bool truth = sample.analysis.truth_x.spread.count > 0;
  const bool turns = sample.run.angle_searched;
  const std::string unit = sample.run.unit;
  std::vector<std::string> header = {"accuracy", "points", "found", "time ms", "S.D. " + unit, "max " + unit};
  if (turns) header.insert(header.end(), {"S.D. deg", "max deg"});
  if (truth) {
    header.push_back("true S.D. " + unit);
    if (turns) header.emplace_back("true S.D. deg");
  }
  header.push_back("bound " + unit);
  if (turns) header.emplace_back("bound deg");
  const bool by_model = results.rows.front().name != results.rows.back().name;
  if (by_model) header[0] = "model";
  Table table{header};
  for (const auto& row : results.rows) {
    if (!test_of(row)) continue;
    const auto& [run, a] = *test_of(row);
    auto& cells = table.emplace_back();
    cells = {by_model ? row.name : fmt::format("{}", row.accuracy),
             fmt::format("{}", row.points),
             fmt::format("{}/{}", a.found, a.frames),
             fixed(a.median_ms, 3),
             fixed(position_sd(a), place),
             fixed(position_max(a), place)};
    if (turns) cells.insert(cells.end(), {fixed(angle_sd(a), place), fixed(angle_max(a), place)});
    if (truth) {
      cells.push_back(fixed(per_axis(a.truth_x, a.truth_y), place));
      if (turns) cells.push_back(fixed(a.truth_angle.spread.sd, place));
    }
    cells.push_back(fixed(bound_of(run.bound), place));
    if (turns) cells.push_back(fixed(run.bound.angle_deg, place));
  }
  return table;
}

/// Everything measured of one test: what, S.D., maximum, what finder and line fits predict themselves, bound, unit.
Table detail_table(const StageTest& test) {
  const auto& [run, a] = test;
  Table table{{"", "S.D.", "max", "predicted", "bound", "unit"}};
  const auto number = [](double v) { return v > 0.0 ? fixed(v, place) : std::string("-"); };
  const auto row = [&](const std::string& what, const Deviations& d, double predicted, double bound,
                       const std::string& unit) {
    if (d.spread.count == 0) return;
    table.push_back(
        {what, fixed(d.spread.sd, place), fixed(d.spread.max, place), number(predicted), number(bound), unit});
  };
  const double xy = bound_of(run.bound);
  const double foreseen = bound_of({a.predicted_x, a.predicted_y});
  const double own = a.fiducial_sigma;
  const double own_angle = a.fiducial_sigma_angle_deg;
  if (a.kind == StageKind::linear) {
    row("pattern: nonlinearity, across the travel", a.pattern_across, foreseen, xy, run.unit);
    row("pattern: from equal steps, along the travel", a.pattern_along, foreseen, xy, run.unit);
    row("fiducials: nonlinearity, across the travel", a.fiducials_across, own, 0.0, run.unit);
    row("fiducials: from equal steps, along the travel", a.fiducials_along, own, 0.0, run.unit);
  } else {
    row("pattern: angle, from equal steps", a.pattern_turn, a.predicted_angle_deg, run.bound.angle_deg, "deg");
    row("fiducials: angle, from equal steps", a.fiducials_turn, own_angle, 0.0, "deg");
  }
  row("pattern relative to fiducials, x", a.relative_x, std::hypot(a.predicted_x, own), std::hypot(run.bound.x, own),
      run.unit);
  row("pattern relative to fiducials, y", a.relative_y, std::hypot(a.predicted_y, own), std::hypot(run.bound.y, own),
      run.unit);
  if (a.with_fiducials > 0) {
    table.push_back({"pattern relative to fiducials, distance", fixed(per_axis(a.relative_x, a.relative_y), place),
                     fixed(a.relative_max, place), number(std::hypot(foreseen, own)), number(std::hypot(xy, own)),
                     run.unit});
  }
  if (run.angle_searched) {
    row("pattern relative to fiducials, angle", a.relative_angle, std::hypot(a.predicted_angle_deg, own_angle),
        std::hypot(run.bound.angle_deg, own_angle), "deg");
  }
  row("pattern against the truth, x", a.truth_x, a.predicted_x, run.bound.x, run.unit);
  row("pattern against the truth, y", a.truth_y, a.predicted_y, run.bound.y, run.unit);
  if (run.angle_searched) {
    row("pattern against the truth, angle", a.truth_angle, a.predicted_angle_deg, run.bound.angle_deg, "deg");
  }
  return table;
}

std::string as_text(const Table& table) {
  if (table.empty()) return {};
  std::vector<std::size_t> widths(table[0].size(), 0);
  for (const auto& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : table) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += i == 0 ? fmt::format("  {:<{}}", row[i], widths[i]) : fmt::format("  {:>{}}", row[i], widths[i]);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string stage_title(const StageTest& test) {
  const auto& [run, a] = test;
  const double step = a.travel / std::max(1.0, a.steps);
  if (a.kind == StageKind::linear) {
    return fmt::format("Translation test: {} images, steps of {} {}, {} deg from +x", a.frames, fixed(step, 4),
                       run.unit, fixed(a.direction_deg, 1));
  }
  return fmt::format("Rotation test: {} images, steps of {} deg", a.frames, fixed(step, 4));
}

std::string reference_of(const StageTest& test) {
  const StageAnalysis& a = test.analysis;
  if (a.with_fiducials > 0) {
    return fmt::format("relative to the fiducials ({} of {} images), whose own noise of {} {}, {} deg is in it",
                       a.with_fiducials, a.frames, fixed(a.fiducial_sigma, place), test.run.unit,
                       fixed(a.fiducial_sigma_angle_deg, place));
  }
  return a.kind == StageKind::linear ? "from the straight line fitted to the travel, as there are no fiducials"
                                     : "of the angle from equal steps, as there are no fiducials";
}

void add_test(Page& page, const StageTest& test, const SourceMapping& mapping, const std::string& folder,
              const std::string& name) {
  page.heading(stage_title(test));
  const auto& [run, a] = test;
  page.paragraph(fmt::format(
      "{}: pattern '{}' (accuracy {}) found in {} of {} images{}. Image noise {} grey levels (of 255). Search time: "
      "median {} ms, maximum {} ms.",
      run.source, run.pattern->name, run.pattern->accuracy, a.found, a.frames,
      run.bad_frames > 0 ? fmt::format(" ({} further frames were bad)", run.bad_frames) : std::string{},
      fixed(run.noise, 2), fixed(a.median_ms, 3), fixed(a.max_ms, 3)));
  Table table = detail_table(test);
  const std::vector<std::string> header = table.front();
  table.erase(table.begin());
  page.table(header, table);
  for (const auto& made : stage_charts(run, a)) {
    const cv::Mat picture = draw_chart(made.chart);
    write_png(folder + "/" + made.file, picture);
    page.chart(picture, made.caption);
  }
  const cv::Mat picture = stage_picture(run, mapping);
  write_png(folder + "/" + name + "-picture.png", picture);
  page.picture(for_gallery(picture), "The first image: the pattern as found, the fiducials numbered.");
}

void write_measured(const QualifyResults& results, const std::string& path) {
  OutputFile file(path);
  file.write_line(
      "test,frame,found,score,x,y,angle_deg,sigma_x,sigma_y,sigma_angle_deg,search_ms,fiducial_x,fiducial_y,"
      "fiducial_angle_deg,noise,true_x,true_y,true_angle_deg");
  for (const auto* test : {&results.rows.back().linear, &results.rows.back().rotary}) {
    if (!*test) continue;
    for (const auto& frame : (*test)->run.frames) {
      const auto value = [](bool there, double v) { return there ? fixed(v, 6) : std::string{}; };
      const bool found = frame.match.has_value();
      const Match match = frame.match.value_or(Match{});
      const bool marked = frame.fiducials.has_value();
      const FiducialPose fiducials = frame.fiducials.value_or(FiducialPose{});
      const bool known = frame.truth.has_value();
      const Pose truth = frame.truth.value_or(Pose{});
      file.write_line(fmt::format(
          "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}", name((*test)->analysis.kind), frame.frame,
          found ? 1 : 0, value(found, match.score), value(found, match.pose.x), value(found, match.pose.y),
          value(found, match.pose.angle_deg), value(found, match.sigma_x), value(found, match.sigma_y),
          value(found, match.sigma_angle_deg), fixed(frame.search_ms, 3), value(marked, fiducials.centre.x()),
          value(marked, fiducials.centre.y()), value(marked, fiducials.angle_deg), fixed(frame.noise, 3),
          value(known, truth.x), value(known, truth.y), value(known, truth.angle_deg)));
    }
  }
}

/// S.D. beside what the noise allows: of the pattern alone where the truth is known, else with the fiducials' own
/// noise.
void add_key_figures(std::vector<Page::Figure>& figures, const StageTest& test) {
  const auto& [run, a] = test;
  const std::string what = a.kind == StageKind::linear ? "translation" : "rotation";
  const bool truth = a.truth_x.spread.count > 0;
  const bool fiducials = !truth && a.with_fiducials > 0;
  const auto number = [](double value, const std::string& unit) { return fixed(value, place) + " " + unit; };
  const std::string of = truth       ? " against the truth"
                         : fiducials ? " relative to the fiducials"
                                     : " from the straight line";
  if (a.kind == StageKind::linear || truth || fiducials) {
    figures.push_back(
        {number(truth ? per_axis(a.truth_x, a.truth_y) : position_sd(a), run.unit), what + ": S.D. in position" + of});
    figures.push_back({number(std::hypot(bound_of(run.bound), fiducials ? a.fiducial_sigma : 0.0), run.unit),
                       "the least that the noise allows"});
  }
  if (run.angle_searched) {
    figures.push_back({number(truth ? a.truth_angle.spread.sd : angle_sd(a), "deg"), what + ": S.D. in angle"});
    figures.push_back({number(std::hypot(run.bound.angle_deg, fiducials ? a.fiducial_sigma_angle_deg : 0.0), "deg"),
                       "the least that the noise allows"});
  }
  figures.push_back({fixed(a.median_ms, 2) + " ms", what + ": search time"});
}

}  // namespace

std::size_t pose_points(const Pattern& pattern) {
  std::size_t points = 0;
  for (const auto& set : pattern.sets) {
    if (set.use == PointUse::refine || set.use == PointUse::outline) points += set.points.size();
  }
  return points;
}

std::string qualify_text(const QualifyResults& results) {
  std::string text = results.title + "\n";
  for (const StageKind kind : {StageKind::linear, StageKind::rotary}) {
    const QualifyRow& last = results.rows.back();
    const auto& test = kind == StageKind::linear ? last.linear : last.rotary;
    if (!test) continue;
    text += "\n" + stage_title(*test) + "; image noise " + fixed(test->run.noise, 2) + " grey levels\n" +
            as_text(closing_table(results, kind)) + "  S.D. and max are " + reference_of(*test) + ".\n\n" +
            as_text(detail_table(*test));
  }
  return text;
}

void write_qualify_report(const QualifyResults& results, const std::string& folder) {
  make_report_folder(folder);
  Page page(results.title);
  const QualifyRow& last = results.rows.back();
  std::vector<Page::Figure> figures;
  for (const auto* test : {&last.linear, &last.rotary}) {
    if (*test) add_key_figures(figures, **test);
  }
  page.key_figures(figures);
  for (const StageKind kind : {StageKind::linear, StageKind::rotary}) {
    Table table = closing_table(results, kind);
    if (table.empty()) continue;
    const auto& test = kind == StageKind::linear ? last.linear : last.rotary;
    page.heading(kind == StageKind::linear ? "Translation: table" : "Rotation: table");
    const std::vector<std::string> header = table.front();
    table.erase(table.begin());
    page.table(header, table);
    if (test) page.paragraph("S.D. and maximum are " + reference_of(*test) + ". Times are medians.");
  }
  if (last.linear) add_test(page, *last.linear, results.mapping, folder, "linear");
  if (last.rotary) add_test(page, *last.rotary, results.mapping, folder, "rotary");
  page.heading("How it was measured");
  page.paragraph(
      "S.D. is the standard deviation of the sample, of position per axis (the root of the mean of both axes' "
      "variances), "
      "max the largest deviation. Fiducials are measured without the pattern finder: a blurred step is fitted by least "
      "squares to the pixels along each side of each square, the lines are intersected to corners, corners averaged to "
      "centres, and centres to one position and, by least squares, one angle.");
  page.paragraph(
      "The bound is that of Cramér and Rao: no unbiased method can do better from these pixels. It counts all pixels "
      "inside the region that was taught, with the noise measured in the images; position, angle where it is searched, "
      "gain and offset are unknown; beside the fiducials their own predicted noise is added. The finder's own "
      "prediction counts the points that it uses, and the noise of the training image. A sample of 20 images tells an "
      "S.D. to about 16%.");
  std::vector<std::vector<std::string>> settings;
  settings.reserve(results.settings.size());
  for (const auto& [what, value] : results.settings) settings.push_back({what, value});
  page.table({"setting", "value"}, settings, true);
  write_measured(results, folder + "/measured.csv");
  page.write(folder + "/report.html");
}

}  // namespace vsfind
