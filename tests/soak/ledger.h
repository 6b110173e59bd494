#pragma once
/// @file
/// The books of a soak: every row that comes is compared with what was served, every gap with what vsfind says it lost.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vsfind::test {

/// What a row says of its frame, whichever way the frame came.
struct SoakRow {
  std::uint64_t frame = 0;
  std::string status;
  std::string pose;  ///< score, x, y, angle …, as written
  bool operator==(const SoakRow&) const = default;
};

/// A line of JSON, or the cells of a CSV by their header; nothing where the line is torn.
[[nodiscard]] std::optional<SoakRow> row_of_json(const std::string& line);
[[nodiscard]] std::optional<SoakRow> row_of_csv(const std::string& line, const std::vector<std::string>& header);
[[nodiscard]] std::vector<std::string> cells_of(const std::string& line);

/// What vsfind tells in its last lines.
struct SoakSummary {
  std::uint64_t frames = 0, bad = 0, dropped = 0, lost = 0, reopened = 0;
  std::uint64_t unwritten = 0;  ///< rows and recorded frames
};
[[nodiscard]] std::optional<SoakSummary> summary_in(const std::string& log);

class Ledger {
 public:
  /// `served`: the rows of the pictures that the camera shows in turn.
  explicit Ledger(std::vector<SoakRow> served) : served_(std::move(served)) {}

  /// A line that came through the pipe, which loses none.
  void add(const std::string& line);
  /// The file of rows on the disk that was full at times.
  void compare_csv(const std::string& text);
  /// The recording beside it.
  void compare_recording(const std::string& path, const std::string& served_recording);
  /// After all of these.
  void settle(const std::string& log, int exit_code);

  [[nodiscard]] const std::vector<std::string>& faults() const { return faults_; }
  [[nodiscard]] std::string text() const;

 private:
  void fault(const std::string& what);
  void follow(const SoakRow& row);
  void hear_complaints(const std::string& log);

  std::vector<SoakRow> served_;
  std::multimap<std::uint64_t, SoakRow> rows_;
  std::vector<std::string> faults_;
  std::uint64_t bad_ = 0;
  std::uint64_t gaps_ = 0;        ///< frames that the rows' numbers jump over
  std::uint64_t repeated_ = 0;    ///< broken frames under the number of another one
  std::uint64_t complaints_ = 0;  ///< of the camera library, of its own making
  std::uint64_t breaks_ = 0;      ///< places where the camera's order of pictures begins anew
  std::string where_broken_;
  std::uint64_t missing_rows_ = 0;
  std::uint64_t missing_frames_ = 0;
  std::uint64_t recorded_ = 0;
  std::optional<std::uint64_t> last_;
  std::optional<std::uint64_t> last_good_;
  std::vector<std::size_t> phases_;  ///< which pictures the last good row may have been
  SoakSummary told_;
};

}  // namespace vsfind::test
