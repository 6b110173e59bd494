#include "app/evaluate/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/drawing.h"
#include "app/output_file.h"
#include "app/overlay.h"
#include "app/report/page.h"
#include "app/result_row.h"

namespace vsfind {
namespace {

constexpr std::size_t most_shots = 24;
const Colour truth_colour(80, 230, 80);
const Colour found_colour(60, 80, 255);

std::string where(const Judgement& j) {
  return fmt::format("frame {}{}, {}", j.frame,
                     j.field == Field::frame ? std::string{} : fmt::format(" {}", name(j.field)), j.model);
}

std::string in_words(const Judgement& j) {
  switch (j.verdict) {
    case Verdict::missed:
      return where(j) + ": missed";
    case Verdict::false_alarm:
      return where(j) + ": false alarm, score " + fixed(j.match->score, 3);
    case Verdict::right:
      break;
  }
  std::string text = where(j) + ": error " + fixed(std::hypot(j.error_x, j.error_y), 4);
  if (j.error_angle_deg) text += ", " + fixed(*j.error_angle_deg, 4) + " deg";
  return text;
}

/// Misses and false alarms before any error.
double badness(const Judgement& j) {
  if (j.verdict != Verdict::right) return 1e9;
  return std::hypot(j.error_x, j.error_y);
}

}  // namespace

Evaluation::Evaluation(TruthFile truth, Tolerance tolerance, std::vector<std::shared_ptr<const Pattern>> patterns)
    : truth_(std::move(truth)),
      tolerance_(tolerance),
      patterns_(std::move(patterns)),
      used_(truth_.rows.size(), false) {
  for (std::size_t i = 0; i < truth_.rows.size(); ++i) rows_of_frame_[truth_.rows[i].frame].push_back(i);
}

int Evaluation::most_instances() const {
  std::size_t most = 1;
  for (const auto& [frame, rows] : rows_of_frame_) {
    for (const auto& pattern : patterns_) {
      for (const Field field : {Field::frame, Field::top, Field::bottom}) {
        const auto expected = std::count_if(rows.begin(), rows.end(), [&](std::size_t i) {
          const TruthRow& row = truth_.rows[i];
          return row.present && row.field.value_or(field) == field && (row.model.empty() || row.model == pattern->name);
        });
        most = std::max(most, static_cast<std::size_t>(expected));
      }
    }
  }
  return static_cast<int>(std::min<std::size_t>(most, 100000));
}

void Evaluation::add(const FrameResult& result, const SourceMapping& mapping) {
  source_ = result.source;
  unit_ = truth_.in_frame_pixels ? "px" : mapping.unit;
  ++frames_;
  const auto rows = rows_of_frame_.find(result.info.sequence);
  const auto judge = [&](Field field, std::size_t p, const std::vector<Match>& matches) {
    std::vector<TruthRow> expected;
    bool marked = false;
    for (const std::size_t i : rows == rows_of_frame_.end() ? std::vector<std::size_t>{} : rows->second) {
      const TruthRow& row = truth_.rows[i];
      if (row.field.value_or(field) != field || (!row.model.empty() && row.model != patterns_[p]->name)) continue;
      marked = used_[i] = true;
      if (row.present) expected.push_back(row);
    }
    if (!marked) {
      ++unmarked_;
      return;
    }
    ++pictures_;
    if (expected.empty()) ++empty_pictures_;
    for (Judgement& judgement : judge_picture(matches, expected, truth_.in_frame_pixels, tolerance_)) {
      judgement.frame = result.info.sequence;
      judgement.field = field;
      judgement.model = patterns_[p]->name;
      judgements_.push_back(std::move(judgement));
    }
  };
  if (result.info.status != FrameStatus::good) {
    ++bad_frames_;  // nothing was searched: what ought to be there is missed
    for (std::size_t p = 0; p < patterns_.size(); ++p) judge(result.info.field, p, {});
  }
  for (const auto& picture : result.pictures) {
    const std::size_t first = judgements_.size();
    search_ms_.push_back(picture.search_ms);
    for (std::size_t p = 0; p < picture.patterns.size(); ++p) judge(picture.field, p, picture.patterns[p].matches);
    keep_shot(picture, mapping, first);
  }
}

void Evaluation::keep_shot(const PictureResult& picture, const SourceMapping& mapping, std::size_t first_judgement) {
  const Judgement* worst = nullptr;
  for (std::size_t i = first_judgement; i < judgements_.size(); ++i) {
    if (worst == nullptr || badness(judgements_[i]) > badness(*worst)) worst = &judgements_[i];
  }
  if (worst == nullptr || picture.grey.pixels.empty()) return;
  if (worst_.size() >= most_shots && badness(*worst) <= worst_.back().badness) return;
  Shot shot{badness(*worst), in_words(*worst), overlay_canvas(picture.grey, picture.field)};
  const auto pattern_of = [&](const std::string& model) -> const Pattern& {
    for (const auto& pattern : patterns_) {
      if (pattern->name == model) return *pattern;
    }
    return *patterns_.front();
  };
  for (std::size_t i = first_judgement; i < judgements_.size(); ++i) {
    const Judgement& j = judgements_[i];
    if (j.truth) {
      const Eigen::Vector2d place(j.truth->x, j.truth->y);
      const Eigen::Vector2d plane = truth_.in_frame_pixels ? mapping.mapping.plane_from_image(place) : place;
      const Pose pose{plane.x(), plane.y(), j.truth->angle_deg.value_or(0.0), j.truth->scale_x.value_or(1.0),
                      j.truth->scale_y.value_or(1.0)};
      draw_outline(shot.picture, pattern_outline(pattern_of(j.model), pose, mapping.mapping), truth_colour, 2);
      draw_plus(shot.picture, mapping.mapping.image_from_plane(plane), 8.0, truth_colour, 1);
    }
    if (j.match) {
      draw_outline(shot.picture, pattern_outline(pattern_of(j.model), j.match->pose, mapping.mapping), found_colour);
      draw_cross(shot.picture, j.match->frame_position, 6.0, found_colour);
    }
  }
  shot.picture = for_gallery(shot.picture);
  const auto place = std::upper_bound(worst_.begin(), worst_.end(), shot.badness,
                                      [](double value, const Shot& other) { return value > other.badness; });
  worst_.insert(place, std::move(shot));
  if (worst_.size() > most_shots) worst_.pop_back();
}

std::size_t Evaluation::count(Verdict verdict) const {
  return static_cast<std::size_t>(std::count_if(judgements_.begin(), judgements_.end(),
                                                [verdict](const Judgement& j) { return j.verdict == verdict; }));
}

Evaluation::Table Evaluation::count_table() const {
  const std::size_t right = count(Verdict::right);
  const std::size_t missed = count(Verdict::missed);
  const std::size_t expected = right + missed;
  double weakest = std::numeric_limits<double>::quiet_NaN();
  double strongest_alarm = std::numeric_limits<double>::quiet_NaN();
  for (const Judgement& j : judgements_) {
    if (j.verdict == Verdict::right) weakest = std::isnan(weakest) ? j.match->score : std::min(weakest, j.match->score);
    if (j.verdict == Verdict::false_alarm) {
      strongest_alarm = std::isnan(strongest_alarm) ? j.match->score : std::max(strongest_alarm, j.match->score);
    }
  }
  const auto or_none = [](double v) { return std::isnan(v) ? std::string("-") : fixed(v, 4); };
  const auto unused = std::count(used_.begin(), used_.end(), false);
  Table table{{"frames", fmt::format("{}", frames_)},
              {"bad frames", fmt::format("{}", bad_frames_)},
              {"pictures judged (times patterns)", fmt::format("{}", pictures_)},
              {"of those, where nothing ought to be", fmt::format("{}", empty_pictures_)},
              {"pictures that the truth says nothing of", fmt::format("{}", unmarked_)},
              {"lines of the truth whose picture did not come", fmt::format("{}", unused)},
              {"instances expected", fmt::format("{}", expected)},
              {"found right",
               fmt::format("{} ({} %)", right,
                           expected > 0 ? fixed(100.0 * static_cast<double>(right) / static_cast<double>(expected), 2)
                                        : std::string("-"))},
              {"missed", fmt::format("{}", missed)},
              {"false alarms", fmt::format("{}", count(Verdict::false_alarm))},
              {"lowest score of a right one", or_none(weakest)},
              {"highest score of a false alarm", or_none(strongest_alarm)},
              {"search time, median ms", fixed(quantile_of(search_ms_, 0.5), 3)},
              {"search time, 99th percentile ms", fixed(quantile_of(search_ms_, 0.99), 3)},
              {"search time, maximum ms", fixed(quantile_of(search_ms_, 1.0), 3)}};
  return table;
}

Evaluation::Table Evaluation::error_table() const {
  std::vector<double> x, y, distance, angle, scale_x, scale_y;
  for (const Judgement& j : judgements_) {
    if (j.verdict != Verdict::right) continue;
    x.push_back(j.error_x);
    y.push_back(j.error_y);
    distance.push_back(std::hypot(j.error_x, j.error_y));
    if (j.error_angle_deg) angle.push_back(*j.error_angle_deg);
    if (j.error_scale_x) scale_x.push_back(*j.error_scale_x);
    if (j.error_scale_y) scale_y.push_back(*j.error_scale_y);
  }
  Table table;
  const auto row = [&](const std::string& what, const std::vector<double>& values) {
    if (values.empty()) return;
    const Spread s = spread_of(values);
    table.push_back({what, fixed(s.mean, 5), fixed(s.sd, 5), fixed(s.rms, 5), fixed(s.max, 5)});
  };
  row("x " + unit_, x);
  row("y " + unit_, y);
  row("distance " + unit_, distance);
  row("angle deg", angle);
  row("scale x", scale_x);
  row("scale y", scale_y);
  return table;
}

std::string Evaluation::text() const {
  std::string text;
  for (const auto& row : count_table()) text += fmt::format("{:<46}{:>16}\n", row[0], row[1]);
  const Table errors = error_table();
  if (!errors.empty()) text += fmt::format("\n{:<14}{:>12}{:>12}{:>12}{:>12}\n", "error", "mean", "S.D.", "RMS", "max");
  for (const auto& row : errors) {
    text += fmt::format("{:<14}{:>12}{:>12}{:>12}{:>12}\n", row[0], row[1], row[2], row[3], row[4]);
  }
  return text;
}

void Evaluation::write_csv(const std::string& path) const {
  OutputFile file(path);
  file.write_line("frame,field,model,verdict,score,true_x,true_y,error_x,error_y,error_angle_deg");
  for (const Judgement& j : judgements_) {
    const bool right = j.verdict == Verdict::right;
    std::string model = j.model;
    if (model.find_first_of(",\"\n\r") != std::string::npos) {
      for (std::size_t at = 0; (at = model.find('"', at)) != std::string::npos; at += 2) model.insert(at, 1, '"');
      model.insert(0, 1, '"');
      model += '"';
    }
    file.write_line(fmt::format("{},{},{},{},{},{},{},{},{},{}", j.frame, name(j.field), model, name(j.verdict),
                                j.match ? fixed(j.match->score, 5) : "", j.truth ? fixed(j.truth->x, 6) : "",
                                j.truth ? fixed(j.truth->y, 6) : "", right ? fixed(j.error_x, 6) : "",
                                right ? fixed(j.error_y, 6) : "",
                                right && j.error_angle_deg ? fixed(*j.error_angle_deg, 6) : ""));
  }
}

}  // namespace vsfind
