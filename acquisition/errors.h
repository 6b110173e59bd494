#pragma once
/// @file
/// The three ways in which vsfind fails, told apart so that the program can end with the documented exit code.
/// The text of each is one complete line for the user: the file, the line or key where there is one, what is wrong,
/// and the allowed values.

#include <stdexcept>

namespace vsfind {

/// A bad option, model, calibration or configuration (exit code 2).
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reading or writing a file failed, or a recording or an image is damaged (exit code 3).
struct IoError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A camera cannot be opened or was lost for good (exit code 4).
struct CameraError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace vsfind
