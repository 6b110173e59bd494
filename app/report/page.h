#pragma once
/// @file
/// A report as one HTML file that needs nothing beside it: pictures are inside, there are no scripts.

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace vsfind {

/// Text with everything that HTML would read as its own replaced, and what is not UTF-8 as U+FFFD.
[[nodiscard]] std::string html_text(const std::string& text);

/// RFC 4648.
[[nodiscard]] std::string base64(const std::vector<unsigned char>& bytes);

/// The picture itself, or a smaller one where it has more pixels than a gallery shows: many are kept in memory.
[[nodiscard]] cv::Mat for_gallery(const cv::Mat& picture);

class Page {
 public:
  explicit Page(std::string title);

  /// All take plain text; it is escaped here.
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// A number that stands out, with what it is below it; a row of neighbouring ones.
  struct Figure {
    std::string value;
    std::string meaning;
  };
  void key_figures(const std::vector<Figure>& figures);
  /// The first column is of names, the others of numbers, unless `text`. Rows are as long as the header.
  void table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows,
             bool text = false);
  /// A chart, as PNG, shown at most at half its pixels' width; two fit side by side.
  void chart(const cv::Mat& picture, const std::string& caption);
  /// A picture beside charts, as JPEG.
  void picture(const cv::Mat& picture, const std::string& caption);
  /// A picture of a gallery, as JPEG, with words below.
  void gallery_picture(const cv::Mat& picture, const std::string& caption);

  /// The whole document.
  [[nodiscard]] std::string html() const;
  /// Writes it. Throws IoError.
  void write(const std::string& path) const;

 private:
  void close_row();
  std::string title_;
  std::string body_;
  const char* open_row_ = nullptr;  ///< class of the row of charts or pictures that is still open
  void open_row(const char* kind);
};

/// Makes the folder where there is none. Throws IoError.
void make_report_folder(const std::string& path);

}  // namespace vsfind
