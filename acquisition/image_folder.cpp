#include "acquisition/image_folder.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <utility>
#include <vector>

#include "acquisition/errors.h"
#include "acquisition/image_file.h"

namespace vsfind {
namespace {

namespace fs = std::filesystem;

/// Lends one image to one frame.
class ImageOwner final : public BufferOwner {
 public:
  explicit ImageOwner(Image image) : image_(std::move(image)) {}
  void give_back(std::uint32_t /*index*/) noexcept override { image_ = Image(); }

 private:
  Image image_;
};

std::vector<std::string> image_names(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::string name = entry->path().filename().string();
    std::error_code ignored;
    if (!name.starts_with('.') && has_image_ending(name) && !entry->is_directory(ignored))
      names.push_back(std::move(name));
  }
  if (error) throw IoError(fmt::format("{}: cannot be read: {}", folder, error.message()));
  if (names.empty()) throw IoError(fmt::format("{}: holds no image: a name must end in {}", folder, image_endings));
  std::sort(names.begin(), names.end());
  return names;
}

class ImageFolder final : public FrameSource {
 public:
  explicit ImageFolder(const std::string& path) : path_(path), names_(image_names(path)) {
    info_.name = path;
    info_.order = FieldOrder::unknown;
    info_.frames = names_.size();
    first_ = load(0);
    info_.width = first_.view().width;
    info_.height = first_.view().height;
    info_.bits = first_.view().bits;
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (stopped_.load(std::memory_order_acquire) || index_ >= names_.size()) return std::nullopt;
    Image image = index_ == 0 ? std::exchange(first_, Image()) : load(index_);
    FrameInfo info;
    info.sequence = index_++;
    info.arrival_ns =
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
            .count();
    info.order = info_.order;
    info.status = image.view().empty() ? FrameStatus::corrupt : FrameStatus::good;
    const ImageView view = image.view();
    return Frame(std::make_shared<ImageOwner>(std::move(image)), 0, view, info);
  }

  void stop() noexcept override { stopped_.store(true, std::memory_order_release); }

 private:
  /// An empty image where it cannot be read, said once in the log.
  [[nodiscard]] Image load(std::size_t index) const {
    try {
      return load_image((fs::path(path_) / names_[index]).string());
    } catch (const IoError& error) {
      spdlog::warn("{}", error.what());
      return {};
    }
  }

  std::string path_;
  std::vector<std::string> names_;
  SourceInfo info_;
  Image first_;
  std::size_t index_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> open_image_folder(const std::string& path) { return std::make_unique<ImageFolder>(path); }

}  // namespace vsfind
