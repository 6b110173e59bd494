/// libFuzzer's door to one entry point, VSFIND_FUZZ_FEED.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/entry_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  vsfind::fuzz::VSFIND_FUZZ_FEED({data, size});
  return 0;
}
