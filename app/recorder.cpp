#include "app/recorder.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "acquisition/errors.h"
#include "app/output_file.h"
#include "app/rotated_files.h"

namespace vsfind {
namespace {

constexpr std::chrono::milliseconds first_pause{250};
constexpr std::chrono::milliseconds longest_pause{10'000};

}  // namespace

Recorder::Recorder(std::string path) : path_(std::move(path)) {
  const OutputFile created(path_);  // what is wrong with the name is told before the first frame comes
}

void Recorder::append(const Frame& frame, const SourceInfo& info) {
  const auto now = std::chrono::steady_clock::now();
  if (lost_in_a_row_ > 0 && now < next_attempt_) {
    ++lost_;
    ++lost_in_a_row_;
    return;
  }
  try {
    if (!info_ || !fit_one_recording(*info_, info)) {
      writer_.reset();
      const std::string name = files_ == 0 ? path_ : numbered_name(path_, files_ + 1);
      if (files_ > 0) spdlog::warn("{}: the frames have changed; recording goes on in {}", info.name, name);
      info_ = info;
      ++files_;
      writer_.emplace(name, info);
    }
    if (!writer_) throw IoError(path_ + ": cannot be begun");
    writer_->append(frame);
  } catch (const std::exception& error) {
    ++lost_;
    if (lost_in_a_row_++ == 0) spdlog::error("{}; searching on without recording", error.what());
    if (!writer_) info_.reset();  // begun anew with the next attempt
    pause_ = std::clamp(pause_ * 2, first_pause, longest_pause);
    next_attempt_ = now + pause_;
    return;
  }
  if (lost_in_a_row_ > 0) spdlog::warn("{}: is recorded again; {} frames are missing", path_, lost_in_a_row_);
  lost_in_a_row_ = 0;
  pause_ = std::chrono::milliseconds{0};
}

void Recorder::close() noexcept {
  try {
    if (writer_) writer_->close();
  } catch (const std::exception& error) {
    ++lost_;
    spdlog::error("{}", error.what());
  }
  writer_.reset();
}

}  // namespace vsfind
