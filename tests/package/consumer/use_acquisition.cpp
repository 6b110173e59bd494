// Opens a recording of two frames written here, and reads it to its end.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "acquisition/errors.h"
#include "acquisition/source.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const std::string path = std::string(arguments[1]) + "/two.y4m";
  std::ofstream(path, std::ios::binary) << "YUV4MPEG2 W4 H2 F25:1 Ip A1:1 Cmono\n"
                                        << "FRAME\nabcdefgh"
                                        << "FRAME\nABCDEFGH";
  const auto source = vsfind::open_sequence(path);
  int frames = 0;
  while (const auto frame = source->next()) {
    if (frame->info().sequence != static_cast<unsigned>(frames)) return 1;
    if (frame->image().width != 4 || frame->image().height != 2) return 1;
    ++frames;
  }
  if (frames != 2) {
    std::fprintf(stderr, "%d frames read of 2\n", frames);
    return 1;
  }
  try {
    (void)vsfind::open_sequence(path + ".missing");
  } catch (const vsfind::IoError&) {
    return 0;
  }
  std::fprintf(stderr, "a missing recording was opened\n");
  return 1;
}
