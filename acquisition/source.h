#pragma once
/// @file
/// Where frames come from: a recording, a folder of images, a camera.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "acquisition/frame.h"

namespace vsfind {

/// A ratio of two positive whole numbers; 0:0 where it is not known.
struct Ratio {
  std::int64_t numerator = 0;
  std::int64_t denominator = 0;
  [[nodiscard]] constexpr bool known() const { return numerator > 0 && denominator > 0; }
  bool operator==(const Ratio&) const = default;
  [[nodiscard]] double value() const { return static_cast<double>(numerator) / static_cast<double>(denominator); }
};

/// How many frames of a camera may wait for whoever searches them: four, or what comes in 100 ms. A machine that is
/// busy with something else holds a thread up for that long now and then.
[[nodiscard]] constexpr std::size_t frames_that_may_wait(const Ratio& frame_rate) {
  constexpr std::int64_t least = 4;
  constexpr std::int64_t most = 64;
  constexpr std::int64_t per_second = 10;
  if (!frame_rate.known()) return least;
  const std::int64_t frames = frame_rate.numerator / frame_rate.denominator / per_second;
  return static_cast<std::size_t>(frames < least ? least : frames > most ? most : frames);
}

/// What a source says about all of its frames.
struct SourceInfo {
  std::string name;  ///< as it stands in the results' `source` column: the path or URI that it was opened with
  int width = 0;     ///< pixels of a whole frame; of a folder those of its first image, 0 where it is damaged
  int height = 0;    ///< rows of a whole frame
  int bits = 8;
  FieldOrder order = FieldOrder::progressive;
  Ratio pixel_aspect;                   ///< pixel width : pixel height of a whole frame
  Ratio frame_rate;                     ///< frames per second
  std::optional<std::uint64_t> frames;  ///< how many there are, where that is known beforehand
  bool live = false;                    ///< a camera: frames come when they come
  bool operator==(const SourceInfo&) const = default;
};

/// Something that happened to a source, once: not per frame.
struct SourceEvent {
  enum class Kind : std::uint8_t {
    fault,      ///< lost, signal gone, frames being dropped …: a warning
    recovered,  ///< the fault is over
    note,       ///< worth a line of an extended log
  };
  Kind kind = Kind::note;
  std::string text;  ///< one complete line that begins with the source's name
};

/// A stream of frames. One thread calls next(); stop() may be called from any other and from a signal's thread.
class FrameSource {
 public:
  using EventHandler = std::function<void(const SourceEvent&)>;

  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  virtual ~FrameSource() = default;

  /// Of a camera it may change during next(): call it on the thread that calls next().
  [[nodiscard]] virtual const SourceInfo& info() const = 0;

  /// The next frame, waiting for it; nothing at the end or after stop(). Throws IoError where a recording is damaged
  /// (after all its whole frames were handed out), CameraError where a camera is lost.
  virtual std::optional<Frame> next() = 0;

  /// Makes a waiting and every later next() return nothing.
  virtual void stop() noexcept = 0;

  /// What a camera counted, as one line for the log and the closing summary ("1200 complete, 3 lost"); "" where there
  /// is nothing. Call it on the thread that calls next(), or after its end.
  [[nodiscard]] virtual std::string statistics() const { return {}; }

  /// Who is told of faults and recoveries: called within next(), on its thread; set before the first next(). Without
  /// one they are not told.
  virtual void on_event(EventHandler handler) { handler_ = std::move(handler); }

 protected:
  void report(SourceEvent::Kind kind, std::string text) const {
    if (handler_) handler_({kind, std::move(text)});
  }

 private:
  EventHandler handler_;
};

/// Opens a folder of images in name order (image_folder.h), or else a `.y4m` recording whatever its name (recording.h).
/// Throws IoError in one line that names the path.
[[nodiscard]] std::unique_ptr<FrameSource> open_sequence(const std::string& path);

}  // namespace vsfind
