#pragma once
/// @file
/// A whole sequence judged: counts, errors, times, and the worst cases with their pictures.

#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/evaluate/judge.h"
#include "app/frame_searcher.h"
#include "app/report/spread.h"

namespace vsfind {

class Evaluation {
 public:
  /// `truth` and `patterns` are kept.
  Evaluation(TruthFile truth, Tolerance tolerance, std::vector<std::shared_ptr<const Pattern>> patterns);

  /// The most instances of one pattern that the truth has in one picture; at least 1.
  [[nodiscard]] int most_instances() const;

  /// Judges one frame; its pictures must have been kept.
  void add(const FrameResult& result, const SourceMapping& mapping);

  /// The result in words, several lines.
  [[nodiscard]] std::string text() const;
  /// All judgements as CSV.
  void write_csv(const std::string& path) const;
  /// report.html with charts and the worst cases. Makes the folder where there is none. Throws IoError.
  void write_report(const std::string& folder, const std::vector<std::pair<std::string, std::string>>& settings) const;

  [[nodiscard]] const std::vector<Judgement>& judgements() const { return judgements_; }
  [[nodiscard]] std::size_t count(Verdict verdict) const;

 private:
  struct Shot {
    double badness = 0.0;
    std::string caption;
    cv::Mat picture;
  };
  using Table = std::vector<std::vector<std::string>>;
  [[nodiscard]] Table count_table() const;
  [[nodiscard]] Table error_table() const;
  void keep_shot(const PictureResult& picture, const SourceMapping& mapping, std::size_t first_judgement);

  TruthFile truth_;
  Tolerance tolerance_;
  std::vector<std::shared_ptr<const Pattern>> patterns_;
  std::map<std::uint64_t, std::vector<std::size_t>> rows_of_frame_;
  std::vector<bool> used_;  ///< rows of the truth whose picture came
  std::vector<Judgement> judgements_;
  std::vector<double> search_ms_;
  std::vector<Shot> worst_;  ///< the worst first
  std::string source_;
  std::string unit_ = "px";
  std::size_t frames_ = 0;
  std::size_t bad_frames_ = 0;
  std::size_t pictures_ = 0;        ///< of a pattern, judged
  std::size_t empty_pictures_ = 0;  ///< of those, where nothing ought to be
  std::size_t unmarked_ = 0;        ///< of a pattern, that the truth says nothing of
};

}  // namespace vsfind
