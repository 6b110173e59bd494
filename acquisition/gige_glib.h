#pragma once
/// @file
/// Aravis' objects and errors owned the C++ way. Included by the gige_*.cpp files only.

#include <arv.h>

#include <memory>
#include <string>

namespace vsfind::gige {

struct Unref {
  template <typename T>
  void operator()(T* object) const {
    g_object_unref(object);
  }
};
template <typename T>
using ObjectPtr = std::unique_ptr<T, Unref>;

struct Free {
  void operator()(void* memory) const { g_free(memory); }
};
/// A list that Aravis made of strings that it keeps.
using StringList = std::unique_ptr<const char*, Free>;

/// What a call of Aravis reports: f(…, error.out()), then `if (error)`.
class CallError {
 public:
  CallError() = default;
  CallError(const CallError&) = delete;
  CallError& operator=(const CallError&) = delete;
  ~CallError() { g_clear_error(&error_); }
  /// Forgets what was reported before.
  [[nodiscard]] GError** out() {
    g_clear_error(&error_);
    return &error_;
  }
  explicit operator bool() const { return error_ != nullptr; }
  [[nodiscard]] std::string text() const { return error_ != nullptr ? error_->message : ""; }
  /// Whether the camera or the way to it is at fault, and not what was asked for.
  [[nodiscard]] bool is_of_connection() const {
    if (error_ == nullptr) return false;
    if (error_->domain != ARV_DEVICE_ERROR) return error_->domain == G_IO_ERROR;
    switch (error_->code) {
      case ARV_DEVICE_ERROR_NOT_CONNECTED:
      case ARV_DEVICE_ERROR_TRANSFER_ERROR:
      case ARV_DEVICE_ERROR_TIMEOUT:
      case ARV_DEVICE_ERROR_NOT_FOUND:
      case ARV_DEVICE_ERROR_NOT_CONTROLLER:
        return true;
      default:
        return false;
    }
  }

 private:
  GError* error_ = nullptr;
};

}  // namespace vsfind::gige
