#include "tests/acquisition/vivid/shown_frame.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "acquisition/recording.h"

namespace vsfind::test {
namespace {

constexpr std::size_t code_bytes = 8;

/// The number and its complement, byte by byte.
std::array<std::uint8_t, code_bytes> code_of(std::uint32_t number) {
  std::array<std::uint8_t, code_bytes> code{};
  for (std::size_t i = 0; i < 4; ++i) {
    code[i] = static_cast<std::uint8_t>(number >> (8U * i));
    code[i + 4] = static_cast<std::uint8_t>(~code[i]);
  }
  return code;
}

}  // namespace

ShownFrames::ShownFrames(const std::string& recording, int width, int height) : width_(width), height_(height) {
  const auto source = open_y4m(recording);
  recorded_width_ = source->info().width;
  recorded_height_ = source->info().height;
  placement_ = {(width - recorded_width_) / 2, (height - recorded_height_) / 4 * 2};
  while (const auto frame = source->next()) {
    auto& pixels = recorded_.emplace_back();
    for (int y = 0; y < recorded_height_; ++y)
      pixels.insert(pixels.end(), frame->image().row8(y), frame->image().row8(y) + recorded_width_);
  }
}

void ShownFrames::draw(std::uint32_t number, std::vector<std::uint8_t>& picture) const {
  picture.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  std::uint32_t noise = number * 2654435761U | 1U;
  std::size_t at = 0;
  for (; at + 4 <= picture.size(); at += 4) {
    noise ^= noise << 13U;
    noise ^= noise >> 17U;
    noise ^= noise << 5U;
    std::memcpy(picture.data() + at, &noise, 4);
  }
  const auto& recorded = recorded_[number % recorded_.size()];
  for (int y = 0; y < recorded_height_; ++y) {
    std::copy_n(recorded.data() + static_cast<std::ptrdiff_t>(y) * recorded_width_, recorded_width_,
                picture.data() + static_cast<std::ptrdiff_t>(y + placement_.y) * width_ + placement_.x);
  }
  const auto code = code_of(number);
  for (const int line : {0, 1})
    std::copy(code.begin(), code.end(), picture.data() + static_cast<std::ptrdiff_t>(line) * width_);
}

std::optional<std::uint32_t> shown_number(const ImageView& picture) {
  if (picture.empty() || picture.bits != 8 || picture.width < static_cast<int>(code_bytes)) return std::nullopt;
  std::uint32_t number = 0;
  for (unsigned i = 0; i < 4; ++i) number |= static_cast<std::uint32_t>(picture.row8(0)[i]) << (8U * i);
  const auto code = code_of(number);
  if (!std::equal(code.begin(), code.end(), picture.row8(0))) return std::nullopt;
  return number;
}

}  // namespace vsfind::test
