// A GigE Vision camera on the network (GVCP and GVSP through Aravis' server) that shows frames of ours: those of a
// recording, or pictures that are a hash of the frame's id, so that a receiver can tell every byte of every frame.
//
//   gige_server ADDRESS SERIAL WIDTHxHEIGHT FPS [--frames SEQUENCE] [--lost RATIO] [--interlaced]
//
// Prints "ready" once it answers, and ends with SIGTERM.

#include <arv.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"
#include "acquisition/source.h"
#include "tests/acquisition/gige_picture.h"

namespace {

using vsfind::ImageView;

// Free registers of the camera, for features of ours.
constexpr std::uint32_t field_mode_register = 0x400;
constexpr std::uint32_t scan_type_register = 0x404;
enum FieldMode : std::uint32_t { field0, field1, field0_first, concatenated, deinterlaced };

struct Camera {
  std::vector<std::vector<std::byte>> frames;  // Mono8, of the size served; none: hashes
  std::atomic<ArvFakeCamera*> fake = nullptr;  // set while the server's thread runs
  bool interlaced = false;
  std::uint64_t sent = 0;
};

/// Row `y` of a picture as the field mode sends it, of `rows` rows, is this row of the frame.
std::size_t source_row(std::uint32_t mode, std::size_t y, std::size_t rows) {
  switch (mode) {
    case field0:
      return 2 * y;
    case field1:
      return 2 * y + 1;
    case concatenated:
      return y < rows / 2 ? 2 * y : 2 * (y - rows / 2) + 1;
    default:
      return y;
  }
}

void fill(ArvBuffer* buffer, void* data, guint32 /*exposure*/, guint32 /*gain*/, ArvPixelFormat format) {
  auto& camera = *static_cast<Camera*>(data);
  std::size_t ignored = 0;
  auto* const bytes = static_cast<std::byte*>(const_cast<void*>(arv_buffer_get_data(buffer, &ignored)));
  const auto width = static_cast<std::size_t>(arv_buffer_get_image_width(buffer));
  const auto rows = static_cast<std::size_t>(arv_buffer_get_image_height(buffer));
  const std::size_t size = width * rows * ARV_PIXEL_FORMAT_BIT_PER_PIXEL(format) / 8;
  if (camera.frames.empty()) {
    vsfind::test::fill_numbered(bytes, size, static_cast<std::uint32_t>(arv_buffer_get_frame_id(buffer)));
    return;
  }
  std::uint32_t mode = deinterlaced;
  if (camera.interlaced) arv_fake_camera_read_register(camera.fake, field_mode_register, &mode);
  const std::uint64_t number = camera.sent++;
  const auto& frame = camera.frames[(mode == field0_first ? number / 2 : number) % camera.frames.size()];
  if (mode == field0_first) mode = number % 2 == 0 ? field0 : field1;
  for (std::size_t y = 0; y < rows; ++y) {
    const std::size_t from = source_row(mode, y, rows) * width;
    if (from + width <= frame.size()) std::memcpy(bytes + y * width, frame.data() + from, width);
  }
}

std::string enumeration(const std::string& name, const std::vector<std::string>& entries, std::uint32_t address) {
  std::string xml = "<Enumeration Name=\"" + name + "\" NameSpace=\"Standard\"><DisplayName>" + name + "</DisplayName>";
  for (std::size_t i = 0; i < entries.size(); ++i)
    xml += "<EnumEntry Name=\"" + entries[i] + "\" NameSpace=\"Standard\"><Value>" + std::to_string(i) +
           "</Value></EnumEntry>";
  return xml + "<pValue>" + name + "Register</pValue></Enumeration><IntReg Name=\"" + name +
         "Register\" NameSpace=\"Custom\"><Address>" + std::to_string(address) +
         "</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort><Sign>Unsigned</Sign>"
         "<Endianess>BigEndian</Endianess></IntReg>";
}

/// The description that the server has anyway, with more pixel formats and the features of interlaced cameras.
std::string description(bool interlaced) {
  ArvFakeCamera* const plain = arv_fake_camera_new("none");
  std::size_t size = 0;
  const char* const text = arv_fake_camera_get_genicam_xml(plain, &size);
  std::string xml(text, size);
  g_object_unref(plain);
  const auto insert_before = [&xml](const std::string& mark, std::size_t from, const std::string& more) {
    const auto place = xml.find(mark, from);
    if (place == std::string::npos) throw std::runtime_error("the camera's description has no " + mark);
    xml.insert(place, more);
  };
  const auto formats = xml.find("<Enumeration Name=\"PixelFormat\"");
  for (const auto& [name, number] : {std::pair{"Mono12Packed", 0x010C0006U}, std::pair{"Mono12", 0x01100005U},
                                     std::pair{"Mono10p", 0x010A0046U}, std::pair{"Jpeg", 0x8108FFFFU}})
    insert_before("<EnumEntry", formats,
                  "<EnumEntry Name=\"" + std::string(name) + "\" NameSpace=\"Standard\"><Value>" +
                      std::to_string(number) + "</Value></EnumEntry>");
  if (interlaced) {
    insert_before("</RegisterDescription>", 0,
                  enumeration("FieldOutputMode",
                              {"Field0", "Field1", "Field0First", "ConcatenatedNewFields", "DeinterlacedNewFields"},
                              field_mode_register) +
                      enumeration("DeviceScanType", {"Areascan", "Progressive"}, scan_type_register));
  }
  return xml;
}

int serve(const std::vector<std::string>& words) {
  if (words.size() < 4) {
    std::cerr << "gige_server ADDRESS SERIAL WIDTHxHEIGHT FPS [--frames SEQUENCE] [--lost RATIO] [--interlaced]\n";
    return 2;
  }
  unsigned width = 0;
  unsigned height = 0;
  if (std::sscanf(words[2].c_str(), "%ux%u", &width, &height) != 2) return 2;
  const double rate = std::atof(words[3].c_str());
  double lost = 0.0;
  Camera camera;
  for (std::size_t i = 4; i < words.size(); ++i) {
    if (words[i] == "--lost") lost = std::atof(words.at(++i).c_str());
    if (words[i] == "--interlaced") camera.interlaced = true;
    if (words[i] != "--frames") continue;
    const auto source = vsfind::open_sequence(words.at(++i));
    while (const auto frame = source->next()) {
      const ImageView& image = frame->image();
      auto& copy = camera.frames.emplace_back();
      for (int y = 0; y < image.height; ++y)
        copy.insert(copy.end(), image.data + y * image.stride, image.data + y * image.stride + image.width);
    }
  }

  const std::string file = "/tmp/vsfind-gige-" + std::to_string(::getpid()) + ".xml";
  std::ofstream(file) << description(camera.interlaced);
  ArvGvFakeCamera* const server = arv_gv_fake_camera_new_full(words[0].c_str(), words[1].c_str(), file.c_str());
  ::unlink(file.c_str());
  if (!arv_gv_fake_camera_is_running(server)) {
    std::cerr << "gige_server: cannot serve at " << words[0] << "\n";
    return 1;
  }
  g_object_set(server, "gvsp-lost-ratio", lost, nullptr);
  camera.fake = arv_gv_fake_camera_get_fake_camera(server);
  arv_fake_camera_set_fill_pattern(camera.fake, fill, &camera);
  arv_fake_camera_write_register(camera.fake, ARV_FAKE_CAMERA_REGISTER_WIDTH, width);
  arv_fake_camera_write_register(camera.fake, ARV_FAKE_CAMERA_REGISTER_HEIGHT, height);
  arv_fake_camera_write_register(camera.fake, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                                 static_cast<guint32>(1e6 / rate));
  if (camera.interlaced) arv_fake_camera_write_register(camera.fake, field_mode_register, deinterlaced);
  std::cout << "ready" << std::endl;
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  int signal = 0;
  sigwait(&ends, &signal);
  g_object_unref(server);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  // Blocked before the server's thread starts, so that sigwait() alone gets them.
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  sigprocmask(SIG_BLOCK, &ends, nullptr);
  try {
    return serve({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << "gige_server: " << error.what() << "\n";
    return 1;
  }
}
