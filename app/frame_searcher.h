#pragma once
/// @file
/// The search stage: one frame in, what was found in it (or in its fields) out.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/frame.h"
#include "app/run_options.h"
#include "finder/search.h"

namespace vsfind {

/// 8-bit pixels of a picture, kept for the overlay after the source's buffer went back.
struct GreyPicture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  ///< row by row, without gaps
};
[[nodiscard]] GreyPicture grey_picture(const ImageView& image);

/// One search: of a whole frame or of a field.
struct PictureResult {
  Field field = Field::frame;
  double search_ms = 0.0;
  std::vector<PatternMatches> patterns;  ///< one per pattern
  GreyPicture grey;                      ///< of the picture that was searched; empty unless asked for
};

/// What became of one frame.
struct FrameResult {
  /// What was searched for, and through which mapping. The patterns are the searcher's, which has to outlive the
  /// result.
  const std::vector<std::shared_ptr<const Pattern>>* patterns = nullptr;
  std::shared_ptr<const SourceMapping> mapping;
  std::string source;            ///< as in the rows
  std::size_t source_index = 0;  ///< of several sources searched at once
  FrameInfo info;
  std::vector<PictureResult> pictures;  ///< in the order of exposure; none for a bad frame
};

/// Which pictures of a frame are searched, in the order of exposure. A frame that is a single field itself is searched
/// as such, unless the other field is asked for.
[[nodiscard]] std::vector<Field> searched_fields(FieldMode mode, const FrameInfo& info);

/// Throws UsageError where the region to search lies outside a picture of that size.
void check_region(const SearchOptions& options, int width, int height, const std::string& source);

class FrameSearcher {
 public:
  /// Throws UsageError as Finder does, and where pattern and mapping do not have the same unit.
  FrameSearcher(std::vector<std::shared_ptr<const Pattern>> patterns, const RunOptions& options, SourceMapping mapping);

  /// Searches every picture of the frame; a bad frame is never searched. Throws UsageError where the calibration or the
  /// region to search is for frames of another size.
  [[nodiscard]] FrameResult search(const std::string& source, const FrameInfo& info, const ImageView& image);

  /// From the next search on. Throws UsageError as the constructor.
  void set_mapping(SourceMapping mapping);

  /// A frame that is not searched, as a result.
  [[nodiscard]] FrameResult unsearched(const std::string& source, const FrameInfo& info) const;

  [[nodiscard]] const std::vector<std::shared_ptr<const Pattern>>& patterns() const { return finder_.patterns(); }

 private:
  Finder finder_;
  std::shared_ptr<const SourceMapping> mapping_;
  SearchOptions search_;
  FieldMode mode_;
  bool keep_pictures_;
};

/// Loads the model files. Throws as load_model does; warns of two patterns of the same name.
[[nodiscard]] std::vector<std::shared_ptr<const Pattern>> load_models(const std::vector<std::string>& paths);

}  // namespace vsfind
