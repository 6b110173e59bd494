#include "tests/fuzz/entry_points.h"

#include <sys/mman.h>
#include <unistd.h>

#include <Eigen/Core>
#include <memory>
#include <stdexcept>
#include <string>

#include "acquisition/errors.h"
#include "acquisition/image_file.h"
#include "acquisition/recording.h"
#include "app/config.h"
#include "app/evaluate/truth_file.h"
#include "app/live_options.h"
#include "app/replay_options.h"
#include "calibration/calibration_file.h"
#include "calibration/import.h"
#include "calibration/point_pairs.h"
#include "tests/fuzz/memory_file.h"

namespace vsfind::fuzz {
namespace {

std::string text_of(Bytes bytes) { return {bytes.begin(), bytes.end()}; }

/// Whether it was taken.
template <typename Parse>
bool refusing(Parse parse) {
  try {
    parse();
  } catch (const UsageError&) {
    return false;
  } catch (const IoError&) {
    return false;
  }
  return true;
}

/// A mapping that came from outside must answer for any point: with a place, or with what is no number.
void use_mapping(const Mapping& mapping) {
  for (const double at : {0.0, 100.0, -1e4, 1e7}) {
    static_cast<void>(mapping.image_from_plane(Eigen::Vector2d(at, at)));
    static_cast<void>(mapping.for_field(Field::bottom).plane_from_image(Eigen::Vector2d(at, -at)));
  }
}

}  // namespace

MemoryFile::MemoryFile(Bytes bytes) : fd_(memfd_create("fuzz", 0)) {
  std::size_t done = 0;
  while (fd_ >= 0 && done < bytes.size()) {
    const ssize_t written = write(fd_, bytes.data() + done, bytes.size() - done);
    if (written <= 0) break;
    done += static_cast<std::size_t>(written);
  }
  if (fd_ < 0 || done < bytes.size()) throw std::logic_error("no file in memory can be made");
}
MemoryFile::~MemoryFile() { close(fd_); }
std::string MemoryFile::path() const { return "/proc/self/fd/" + std::to_string(fd_); }

bool feed_y4m(Bytes bytes) {
  const MemoryFile file(bytes);
  return refusing([&] {
    const auto source = open_y4m(file.path());
    unsigned sum = 0;
    for (int i = 0; i < 16; ++i) {
      const auto frame = source->next();
      if (!frame) break;
      const ImageView& image = frame->image();
      if (image.empty()) continue;
      for (const int y : {0, image.height / 2, image.height - 1}) {
        for (const int x : {0, image.width - 1}) sum += static_cast<unsigned>(image.at(x, y));
      }
    }
    volatile unsigned used = sum;
    static_cast<void>(used);
  });
}

bool feed_image(Bytes bytes) {
  const MemoryFile file(bytes);
  return refusing([&] {
    const Image image = load_image(file.path());
    const ImageView& view = image.view();
    if (view.empty()) throw std::logic_error("an image without pixels was taken");
    volatile int used = view.at(0, 0) + view.at(view.width - 1, view.height - 1);
    static_cast<void>(used);
  });
}

bool feed_calibration(Bytes bytes) {
  return refusing([&] {
    const Calibration calibration = parse_calibration(text_of(bytes), "fuzz.yaml");
    use_mapping(mapping_of(calibration));
    // What was read is written and read again.
    static_cast<void>(parse_calibration(calibration_text(calibration), "again.yaml"));
  });
}

bool feed_import(Bytes bytes) {
  return refusing([&] {
    const Calibration calibration = parse_foreign_calibration(text_of(bytes), "fuzz.yaml");
    use_mapping(mapping_of(calibration));
    try {
      static_cast<void>(parse_calibration(calibration_text(calibration), "again.yaml"));
    } catch (const std::exception& error) {
      throw std::logic_error(std::string("an imported calibration cannot be read back: ") + error.what());
    }
  });
}

bool feed_points(Bytes bytes) {
  return refusing([&] {
    const auto pairs = parse_point_pairs(text_of(bytes), "fuzz.csv");
    SolveOptions options;
    options.image_width = 640;
    options.image_height = 480;
    BoardView used;
    static_cast<void>(solve_points(pairs, options, "fuzz.csv", used));
  });
}

bool feed_config(Bytes bytes) {
  const MemoryFile file(bytes);
  const bool replayed = refusing([&] {
    ReplayRequest request;
    apply_config(load_config(file.path()), replay_settings(request));
    complete_run_options(request.options);
  });
  const bool live = refusing([&] {
    LiveRequest request;
    request.config = file.path();
    apply_live_config(request, live_settings(request));
  });
  return replayed || live;
}

bool feed_truth(Bytes bytes) {
  return refusing([&] { static_cast<void>(parse_truth(text_of(bytes), "fuzz.csv")); });
}

const std::vector<EntryPoint>& entry_points() {
  static const std::vector<EntryPoint> all{
      {"y4m", feed_y4m},       {"image", feed_image},   {"model", feed_model},   {"calibration", feed_calibration},
      {"import", feed_import}, {"points", feed_points}, {"config", feed_config}, {"truth", feed_truth}};
  return all;
}

}  // namespace vsfind::fuzz
