#include <filesystem>

#include "acquisition/image_folder.h"
#include "acquisition/recording.h"
#include "acquisition/source.h"

namespace vsfind {

std::unique_ptr<FrameSource> open_sequence(const std::string& path) {
  // What cannot be looked at is left to open_y4m, whose complaint gives the system's reason.
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return open_image_folder(path);
  return open_y4m(path);
}

}  // namespace vsfind
