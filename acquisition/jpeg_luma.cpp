#include "acquisition/jpeg_luma.h"

#include <fmt/format.h>
#include <jpeglib.h>

#include <array>
#include <csetjmp>
#include <cstdio>  // before jpeglib.h, which needs it

#include "acquisition/errors.h"

namespace vsfind {
namespace {

/// libjpeg's error handler with the way out of its functions.
struct Handler {
  jpeg_error_mgr manager{};  // first: libjpeg knows only this
  std::jmp_buf out{};
  std::array<char, JMSG_LENGTH_MAX> message{};
};

void give_up(j_common_ptr codec) {
  auto* handler = reinterpret_cast<Handler*>(codec->err);
  codec->err->format_message(codec, handler->message.data());
  std::longjmp(handler->out, 1);
}

/// Warnings tell of damaged pixels and end the decoding, too; traces do not matter.
void take_message(j_common_ptr codec, int level) {
  if (level < 0) give_up(codec);
}

/// False where `handler.message` says what is wrong. Nothing in here has a destructor: libjpeg leaves by a long jump.
bool decode(jpeg_decompress_struct& codec, Handler& handler, std::span<const std::byte> jpeg, std::uint8_t* luma,
            JDIMENSION width, JDIMENSION height) {
  if (setjmp(handler.out) != 0) return false;
  jpeg_create_decompress(&codec);
  jpeg_mem_src(&codec, reinterpret_cast<const unsigned char*>(jpeg.data()), jpeg.size());
  jpeg_read_header(&codec, TRUE);
  codec.out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(&codec);
  if (codec.output_width != width || codec.output_height != height || codec.output_components != 1) return false;
  while (codec.output_scanline < height) {
    JSAMPROW row = luma + std::size_t{codec.output_scanline} * width;
    jpeg_read_scanlines(&codec, &row, 1);
  }
  jpeg_finish_decompress(&codec);
  return true;
}

}  // namespace

void decode_jpeg_luma(std::span<const std::byte> jpeg, std::uint8_t* luma, int width, int height) {
  Handler handler;
  jpeg_decompress_struct codec{};
  codec.err = jpeg_std_error(&handler.manager);
  handler.manager.error_exit = give_up;
  handler.manager.emit_message = take_message;
  const bool good = decode(codec, handler, jpeg, luma, static_cast<JDIMENSION>(width), static_cast<JDIMENSION>(height));
  jpeg_destroy_decompress(&codec);
  if (good) return;
  const char* reason = handler.message[0] != '\0' ? handler.message.data() : "its headers do not agree";
  throw IoError(fmt::format("is damaged: {}", reason));
}

}  // namespace vsfind
