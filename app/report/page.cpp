#include "app/report/page.h"

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "acquisition/errors.h"
#include "app/output_file.h"
#include "app/row_writer.h"
#include "app/version.h"

namespace vsfind {
namespace {

constexpr const char* style =
    "body{font:15px/1.5 system-ui,sans-serif;color:#1d2733;background:#f4f6f8;margin:0}"
    "main{max-width:1120px;margin:0 auto;padding:28px 24px 60px;background:#fff}"
    "h1{font-size:25px;margin:0 0 4px}h2{font-size:18px;margin:30px 0 8px;border-bottom:1px solid #d7dee5;"
    "padding-bottom:4px}p{margin:6px 0 10px;max-width:80ch}"
    "table{border-collapse:collapse;margin:10px 0;font-variant-numeric:tabular-nums;font-size:14px}"
    "th,td{padding:4px 12px;text-align:right;border-bottom:1px solid #e3e8ed}th{background:#f0f3f6;font-weight:600}"
    "th:first-child,td:first-child,table.text td,table.text th{text-align:left}"
    ".figures{display:flex;flex-wrap:wrap;gap:12px;margin:16px 0}"
    ".figures div{background:#f0f5fa;border-radius:6px;padding:10px 18px}"
    ".figures b{display:block;font-size:21px}.figures span{font-size:13px;color:#52606d}"
    ".charts,.gallery{display:flex;flex-wrap:wrap;gap:16px;margin:10px 0}"
    ".charts figure{margin:0;width:524px;max-width:100%}.gallery figure{margin:0;width:344px;max-width:100%}"
    "figure img{width:100%;border:1px solid #e3e8ed}figcaption{font-size:13px;color:#52606d;overflow-wrap:anywhere}"
    // A click on a picture shows it large, a click elsewhere puts it back.
    ".gallery img,.charts img{cursor:zoom-in}figure{outline:none}"
    "figure:focus img{position:fixed;inset:0;margin:auto;width:auto;max-width:96vw;max-height:96vh;z-index:1;"
    "box-shadow:0 0 0 100vmax #1d2733cc;cursor:zoom-out}"
    "footer{margin-top:34px;font-size:13px;color:#7b8794}";

std::string picture_tag(const cv::Mat& picture, const char* ending, const std::string& caption) {
  std::vector<unsigned char> bytes;
  const bool jpeg = std::string_view(ending) == ".jpg";
  const std::vector<int> how =
      jpeg ? std::vector<int>{cv::IMWRITE_JPEG_QUALITY, 88} : std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 9};
  if (!cv::imencode(ending, picture, bytes, how)) throw IoError("a picture of the report cannot be encoded");
  return "<figure tabindex=\"0\"><img alt=\"" + html_text(caption) + "\" src=\"data:image/" + (jpeg ? "jpeg" : "png") +
         ";base64," + base64(bytes) + "\"><figcaption>" + html_text(caption) + "</figcaption></figure>\n";
}

}  // namespace

std::string html_text(const std::string& text) {
  std::string safe;
  for (const char c : as_utf8(text)) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        // HTML has no characters for most control codes.
        safe += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  }
  return safe;
}

std::string base64(const std::vector<unsigned char>& bytes) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const unsigned group = (static_cast<unsigned>(bytes[i]) << 16U) |
                           (left > 1 ? static_cast<unsigned>(bytes[i + 1]) << 8U : 0U) |
                           (left > 2 ? static_cast<unsigned>(bytes[i + 2]) : 0U);
    text += letters[group >> 18U];
    text += letters[(group >> 12U) & 63U];
    text += left > 1 ? letters[(group >> 6U) & 63U] : '=';
    text += left > 2 ? letters[group & 63U] : '=';
  }
  return text;
}

cv::Mat for_gallery(const cv::Mat& picture) {
  constexpr int most = 1280;
  const int side = std::max(picture.cols, picture.rows);
  if (side <= most) return picture;
  const double scale = static_cast<double>(most) / side;
  cv::Mat smaller;
  const cv::Size size(std::max(1, static_cast<int>(picture.cols * scale)),
                      std::max(1, static_cast<int>(picture.rows * scale)));
  cv::resize(picture, smaller, size, 0.0, 0.0, cv::INTER_AREA);
  return smaller;
}

Page::Page(std::string title) : title_(std::move(title)) {}

void Page::close_row() {
  if (open_row_ != nullptr) body_ += "</div>\n";
  open_row_ = nullptr;
}

void Page::open_row(const char* kind) {
  if (open_row_ != nullptr && std::string_view(open_row_) == kind) return;
  close_row();
  body_ += std::string("<div class=\"") + kind + "\">\n";
  open_row_ = kind;
}

void Page::heading(const std::string& text) {
  close_row();
  body_ += "<h2>" + html_text(text) + "</h2>\n";
}

void Page::paragraph(const std::string& text) {
  close_row();
  body_ += "<p>" + html_text(text) + "</p>\n";
}

void Page::key_figures(const std::vector<Figure>& figures) {
  close_row();
  body_ += "<div class=\"figures\">\n";
  for (const auto& figure : figures) {
    body_ += "<div><b>" + html_text(figure.value) + "</b><span>" + html_text(figure.meaning) + "</span></div>\n";
  }
  body_ += "</div>\n";
}

void Page::table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows, bool text) {
  close_row();
  body_ += text ? "<table class=\"text\"><tr>" : "<table><tr>";
  for (const auto& cell : header) body_ += "<th>" + html_text(cell) + "</th>";
  body_ += "</tr>\n";
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const auto& cell : row) body_ += "<td>" + html_text(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</table>\n";
}

void Page::chart(const cv::Mat& picture, const std::string& caption) {
  open_row("charts");
  body_ += picture_tag(picture, ".png", caption);
}

void Page::picture(const cv::Mat& picture, const std::string& caption) {
  open_row("charts");
  body_ += picture_tag(picture, ".jpg", caption);
}

void Page::gallery_picture(const cv::Mat& picture, const std::string& caption) {
  open_row("gallery");
  body_ += picture_tag(picture, ".jpg", caption);
}

std::string Page::html() const {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
         html_text(title_) + "</title><style>" + style + "</style></head>\n<body><main>\n<h1>" + html_text(title_) +
         "</h1>\n" + body_ + (open_row_ != nullptr ? "</div>\n" : "") + "<footer>vsfind " + version_text +
         "</footer>\n</main></body></html>\n";
}

void Page::write(const std::string& path) const { OutputFile(path).write(html()); }

void make_report_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw IoError(path + ": the folder cannot be made: " + error.message());
}

}  // namespace vsfind
