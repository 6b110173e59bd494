#pragma once
/// @file
/// Recordings: YUV4MPEG2 (.y4m) files read as a source, and written losslessly from any source.
///
/// Mono is read and written with 8 to 16 bits; of colour recordings (4:2:0, 4:2:2, 4:4:4, 4:4:0, 4:1:1, 4:1:0) the
/// luma is read as it stands, studio range or full range alike. What a Frame knows and the format does not (sequence,
/// timestamp and clock, field, status) is kept in a parameter of the frame's line that other programs ignore, see
/// y4m_header.h. In recordings of other programs the sequence counts from 0, and the timestamp is the number of the
/// frame divided by the frame rate (Clock::recording; Clock::none where the rate is unknown).
///
/// A picture that is a single field is written in a whole frame, each of its rows twice, so that other programs show
/// it in its true shape; it comes back as the field alone.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/frame.h"
#include "acquisition/source.h"

namespace vsfind {

/// Opens a recording: a file, a pipe or a device, read from front to end, of any length. Throws IoError in one line
/// that names the file. Frames are read straight into their buffers, of which recording_buffers() (buffer_pool.h)
/// may be held at once. After the last whole frame of a damaged recording, next() throws IoError once.
[[nodiscard]] std::unique_ptr<FrameSource> open_y4m(const std::string& path);

/// Whether frames of two sources can stand in one recording: their size, bits, field order and pixel aspect agree.
[[nodiscard]] bool fit_one_recording(const SourceInfo& a, const SourceInfo& b);

/// Writes a recording, mono, frame by frame: what append() was given is in the file when it returns.
class RecordingWriter {
 public:
  /// Creates the file, or empties it, and writes its header from width, height, bits, order, pixel_aspect and
  /// frame_rate of `info`. Throws UsageError where the size or the bits cannot be written, IoError where the file
  /// cannot.
  RecordingWriter(const std::string& path, const SourceInfo& info);
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) noexcept;
  /// Closes without a complaint.
  ~RecordingWriter();

  void append(const Frame& frame) { append(frame.image(), frame.info()); }
  /// A good picture must have the recording's bits and its size, or that of its field: UsageError. Of a picture that
  /// is not good, what fits is written and the rest is black. Throws IoError where the disk is full, for example; the
  /// file then ends with the last whole frame.
  void append(const ImageView& image, const FrameInfo& info);

  /// Throws IoError where the system reports at last that the file could not be written.
  void close();

  /// Frames written.
  [[nodiscard]] std::uint64_t frames() const;
  /// Bytes written, with the header.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vsfind
