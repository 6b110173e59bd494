#pragma once
/// @file
/// How arrays of points are laid out for the kernels: with room for `count` rounded up to a multiple of `point_block`,
/// and computed that far.

namespace vsfind::kernels {

inline constexpr int point_block = 8;
[[nodiscard]] constexpr int padded(int count) { return (count + point_block - 1) / point_block * point_block; }

}  // namespace vsfind::kernels
