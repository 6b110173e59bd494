/// Everything that is done in the guest, one after another: `vivid_guest FOLDER RECORDING MODEL` leaves recordings,
/// logs and exit codes in FOLDER, for the tests on the host to look at. Nothing is judged here; where a step cannot be
/// taken, FOLDER/NAME.failed says why. The pages of the numbers below are in the kernel's documentation of vivid.

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/acquisition/vivid/guest_run.h"
#include "tests/acquisition/vivid/shown_frame.h"
#include "tests/acquisition/vivid/vivid_device.h"

namespace vsfind::test {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

const std::string camera = "/dev/video0";
const std::string output = "/dev/video1";
const std::string multi_planar = "/dev/video20";
constexpr std::uint32_t webcam = 0;
constexpr std::uint32_t s_video = 1;
constexpr std::uint32_t hdmi = 2;

Words operator+(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

class Guest {
 public:
  Guest(std::string folder, std::string recording, std::string model)
      : folder_(std::move(folder)), recording_(std::move(recording)), model_(std::move(model)) {}

  void run() {
    loops();
    live();
    patterns();
    formats();
    planes();
    faults();
    settings();
  }

 private:
  [[nodiscard]] std::string file(const std::string& name) const { return folder_ + "/" + name; }

  /// Takes a step; what goes wrong is written down, and the next one taken.
  void step(const std::string& name, const std::function<void()>& action) const {
    const auto begin = std::chrono::steady_clock::now();
    std::string end = "done";
    try {
      action();
    } catch (const std::exception& error) {
      std::ofstream(file(name + ".failed")) << error.what() << "\n";
      end = error.what();
    }
    std::cout << fmt::format("{}: {} ({:.2f} s)\n", name, end,
                             std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count())
              << std::flush;
  }

  [[nodiscard]] Words record(const std::string& name, const Words& more, const std::string& device = camera) const {
    return Words{"record", "-v", "--source", "v4l2:" + device, "-o", file(name + ".y4m")} + more;
  }
  void to_end(const std::string& name, const Words& arguments) const { GuestRun(folder_, name, arguments).wait(); }

  static Words analogue(const std::string& standard, const std::string& fields, const std::string& format) {
    return {"--input", "S-Video 0", "--standard", standard, "--field-order", fields, "--pixel-format", format};
  }

  void loop(const std::string& name, Signal signal, int height, std::uint32_t field, const std::string& format,
            int frames, const Words& input) const {
    step(name, [&] {
      const ShownFrames shown(recording_, signal == Signal::hdmi ? 640 : 720, height);
      select_vivid(camera, signal == Signal::hdmi ? hdmi : s_video, signal != Signal::hdmi, signal == Signal::ntsc);
      if (signal == Signal::hdmi) set_vivid_timings(camera);
      shrink_picture(camera);  // an earlier program's, to be put right
      const Showing showing(output, signal, shown, field, format == "YUYV");
      to_end(name, record(name, input + Words{"--control", "OSD Text Mode=None", "--control", "loop_video=on",
                                              "--frames", std::to_string(frames)}));
    });
  }

  /// Our own frames, through the driver's output and back.
  void loops() const {
    loop("loop_pal_interlaced", Signal::pal, 576, V4L2_FIELD_INTERLACED, "GREY", 52,
         analogue("PAL", "interlaced", "GREY"));
    loop("loop_pal_alternate", Signal::pal, 576, V4L2_FIELD_ALTERNATE, "YUYV", 52,
         analogue("PAL", "alternate", "YUYV"));
    loop("loop_pal_interlaced_tb", Signal::pal, 576, V4L2_FIELD_INTERLACED_TB, "YUYV", 12,
         analogue("PAL", "interlaced-tb", "YUYV"));
    loop("loop_ntsc_interlaced", Signal::ntsc, 480, V4L2_FIELD_INTERLACED, "YUYV", 12,
         analogue("NTSC", "interlaced", "YUYV"));
    loop("loop_ntsc_interlaced_bt", Signal::ntsc, 480, V4L2_FIELD_INTERLACED_BT, "GREY", 12,
         analogue("NTSC", "interlaced_bt", "GREY"));
    loop("loop_ntsc_alternate", Signal::ntsc, 480, V4L2_FIELD_ALTERNATE, "GREY", 24,
         analogue("NTSC", "alternate", "GREY"));
    loop("loop_progressive", Signal::hdmi, 480, V4L2_FIELD_NONE, "GREY", 24,
         {"--input", "HDMI 0", "--pixel-format", "GREY", "--size", "640x480"});
    step("loop_off", [] { set_vivid(camera, "Loop Video", 0); });
  }

  /// What is shown is searched as it comes.
  void live() const {
    step("live", [&] {
      const ShownFrames shown(recording_, 720, 576);
      select_vivid(camera, s_video, true, false);
      const Showing showing(output, Signal::pal, shown, V4L2_FIELD_INTERLACED, false);
      to_end("live", Words{"live",           "-v",
                           "--source",       "v4l2:" + camera,
                           "--model",        model_,
                           "--field",        "split",
                           "--pixel-aspect", "1:1",
                           "--csv",          file("live.csv"),
                           "--record",       file("live.y4m"),
                           "--frames",       "4",
                           "--control",      "OSD Text Mode=None",
                           "--control",      "loop_video=on"} +
                         analogue("PAL", "interlaced", "GREY"));
    });
    step("live_off", [] { set_vivid(camera, "Loop Video", 0); });
  }

  [[nodiscard]] static Words pattern(const std::string& name) {
    return {"--control", "Test Pattern=" + name, "--control", "OSD Text Mode=None"};
  }

  /// Pictures that tell the fields apart, and rows 16 lines off, in every field order.
  void patterns() const {
    for (const std::string standard : {"PAL", "NTSC"}) {
      for (const std::string fields :
           {"interlaced", "interlaced_tb", "interlaced_bt", "seq_tb", "seq_bt", "alternate", "top", "bottom"}) {
        for (const auto& [kind, picture] :
             {std::pair("lines", "Alternating Hor Lines"), {"squares", "16x16 Checkers"}}) {
          const std::string name = fmt::format("{}_{}_{}", kind, standard, fields);
          step(name, [&, picture = picture] {
            to_end(name, record(name, analogue(standard, fields, "GREY") + pattern(picture) + Words{"--frames", "2"}));
          });
        }
      }
    }
  }

  /// The same picture in every kind of pixel format.
  void formats() const {
    for (const std::string format : {"GREY", "Y10", "Y12", "Y16", "Y16-BE", "YUYV", "UYVY", "NV12", "RGB3", "BA81"}) {
      const std::string name = "format_" + format;
      step(name, [&] {
        to_end(name, record(name, Words{"--input", "0", "--size", "640x360", "--frame-rate", "40", "--pixel-format",
                                        format, "--frames", "2"} +
                                      pattern("Gray Ramp")));
      });
    }
  }

  /// The same picture from a device of several planes, each in a memory of its own or all in one.
  void planes() const {
    for (const std::string format : {"GREY", "YUYV", "NV12", "NM12", "NM16", "YM12", "RGB3"}) {
      const std::string name = "planes_" + format;
      step(name, [&] {
        to_end(name,
               record(name,
                      Words{"--size", "640x360", "--frame-rate", "40", "--pixel-format", format, "--frames", "2"} +
                          pattern("Gray Ramp"),
                      multi_planar));
      });
    }
    step("planes_default", [&] {
      to_end("planes_default", record("planes_default", {"--size", "640x360", "--frames", "2"}, multi_planar));
    });
  }

  /// Records until `end`, with `inject` called when eight frames are there, and eight more waited for after that. A
  /// signal ends it.
  void fault(const std::string& name, const Words& input, const std::function<void()>& inject,
             int frames_after = 8) const {
    step(name, [&] {
      GuestRun run(folder_, name, record(name, input));
      constexpr int before = 8;
      wait_for_frames(name, before, run);
      inject();
      wait_for_frames(name, frames_in(name) + frames_after, run);
      run.kill(SIGINT);
      run.wait();
    });
  }

  /// Whole frames of 720 pixels by so many rows in a recording that is being made.
  [[nodiscard]] int frames_in(const std::string& name, std::uintmax_t rows = 576) const {
    std::error_code error;
    const auto size = fs::file_size(file(name + ".y4m"), error);
    const std::uintmax_t frame = 720 * rows + 63;
    return error ? 0 : static_cast<int>(size / frame);
  }
  void wait_for_frames(const std::string& name, int count, GuestRun& run, std::uintmax_t rows = 576) const {
    wait_until(fmt::format("{} frames of {}", count, name),
               [&] { return frames_in(name, rows) >= count || run.ended(); });
    if (run.ended()) run.wait();
  }

  /// What becomes of a run that follows the signal when that changes from PAL to NTSC.
  void other_size(const std::string& name, const Words& arguments) const {
    step(name, [&] {
      select_vivid(camera, s_video, true, false);
      GuestRun run(folder_, name, arguments);
      constexpr int frames = 8;
      wait_for_frames(name, frames, run);
      set_vivid(camera, "Standard", 0);  // NTSC
      set_vivid(camera, "Standard Signal Mode", 4);
      wait_for_frames(name + "-2", frames, run, 480);
      run.kill(SIGINT);
      run.wait();
    });
    step(name + "_off", [] { set_vivid(camera, "Standard Signal Mode", 0); });
  }

  void faults() const {
    // A picture that stands still, so that every frame can be compared with the first one.
    const Words pal = analogue("PAL", "interlaced", "GREY") + pattern("16x16 Checkers");
    const auto pause = [](int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); };
    const auto set = [](const char* control, std::int64_t value) { set_vivid(camera, control, value); };

    fault(
        "fault_dropped", pal, [&] { set("Percentage of Dropped Buffers", 40); }, 24);
    step("no_more_dropped", [&] { set("Percentage of Dropped Buffers", 0); });
    fault("fault_flagged", pal, [&] { set("Inject V4L2_BUF_FLAG_ERROR", 1); });
    fault("fault_stream_error", pal, [&] { set("Inject Fatal Streaming Error", 1); });
    fault("fault_no_signal", pal, [&] {
      set("Standard Signal Mode", 1);
      pause(700);
      set("Standard Signal Mode", 0);
    });
    fault("fault_other_standard", pal, [&] {
      set("Standard", 0);  // NTSC
      set("Standard Signal Mode", 4);
      pause(700);
      set("Standard Signal Mode", 0);
    });
    // Without a standard it follows the signal.
    const Words following = Words{"--input", "S-Video 0", "--pixel-format", "GREY"} + pattern("16x16 Checkers");
    other_size("record_other_size", record("record_other_size", following));
    other_size("live_other_size",
               Words{"live", "-v", "--source", "v4l2:" + camera, "--model", model_, "--field", "split", "--csv",
                     file("live_other_size.csv"), "--record", file("live_other_size.y4m")} +
                   following);
    const auto log_says = [&](const std::string& step, const std::string& text) {
      std::ifstream log(file(step + ".err"));
      return std::string(std::istreambuf_iterator<char>(log), {}).find(text) != std::string::npos;
    };
    fault("fault_silent", pal + Words{"--frame-timeout", "1.5"}, [&] {
      set("Percentage of Dropped Buffers", 100);
      wait_until("no frame is complained about", [&] { return log_says("fault_silent", "no frame for"); });
      set("Percentage of Dropped Buffers", 0);
    });
    fault("fault_disconnect", pal, [&] { set("Disconnect", 1); });
    fault("fault_unbind", pal, [&] {
      std::ofstream("/sys/bus/platform/drivers/vivid/unbind") << "vivid.0" << std::flush;
      wait_until("the device vanishes", [] { return !fs::exists(camera); });
      pause(300);
      std::ofstream("/sys/bus/platform/drivers/vivid/bind") << "vivid.0" << std::flush;
      wait_until("the device returns", [] { return fs::exists(camera); });
    });
    fault("fault_held", pal, [&] {
      to_end("second_program", record("second_program", pal + Words{"--frames", "2"}));
      to_end("cameras_held", {"cameras"});
    });
    step("fault_never_starts", [&] {
      set("Inject VIDIOC_STREAMON Error", 1);
      to_end("fault_never_starts", record("fault_never_starts", pal + Words{"--frames", "2"}));
    });
    step("fault_disk_full", [&] {
      const fs::path small = fs::path(folder_).parent_path() / "small";
      if (::mount("tmpfs", small.c_str(), "tmpfs", 0, "size=3m") != 0) throw std::runtime_error("no small disk");
      const std::string full = small / "full.y4m";
      to_end("fault_disk_full", Words{"record", "--source", "v4l2:" + camera, "-o", full} + pal);
      fs::copy_file(full, file("fault_disk_full.y4m"), fs::copy_options::overwrite_existing);
    });
    // The driver's 32-bit counter passes its end after 128 frames.
    step("fault_wrap", [&] {
      set("Wrap Sequence Number", 1);
      to_end("fault_wrap", record("fault_wrap", {"--input", "0", "--size", "320x180", "--frame-rate", "60",
                                                 "--pixel-format", "GREY", "--frames", "150"}));
    });
    step("no_more_wrapped", [&] { set("Wrap Sequence Number", 0); });
  }

  void settings() const {
    step("cameras", [&] {
      to_end("cameras", {"cameras"});
      to_end("cameras_json", {"cameras", "--json"});
    });
    const Words to{"-o", file("refused.y4m"), "--frames", "1"};
    const auto refused = [&](const std::string& name, const Words& words, const std::string& device = camera) {
      step("refused_" + name, [&] {
        to_end("refused_" + name, Words{"record", "--source", "v4l2:" + device} + to + words);
      });
    };
    refused("input", {"--input", "SCART"});
    refused("standard", {"--input", "1", "--standard", "PAL-X"});
    refused("standard_of_a_webcam", {"--input", "0", "--standard", "PAL"});
    refused("size", {"--input", "0", "--size", "641x359"});
    refused("pixel_format", {"--input", "0", "--pixel-format", "Y99"});
    refused("field_order", {"--input", "1", "--standard", "PAL", "--field-order", "none"});
    refused("field_order_word", {"--input", "1", "--field-order", "diagonal"});
    refused("frame_rate", {"--input", "0", "--size", "640x360", "--frame-rate", "1000"});
    refused("control", {"--input", "0", "--control", "Colour of the Sky=7"});
    refused("control_value", {"--input", "0", "--control", "Brightness=999"});
    refused("control_menu", {"--input", "0", "--control", "test_pattern=Stripes"});
    refused("control_read_only", {"--input", "0", "--control", "read_only_integer_32_bits=1"});
    refused("exposure", {"--input", "0", "--exposure", "1000"});
    refused("gain", {"--input", "0", "--gain", "100000"});
    refused("device", {}, "/dev/video9");
    refused("output_device", {}, output);
    refused("no_v4l2", {}, "/dev/null");
    refused("a_file", {}, "/etc/passwd");
    step("settings", [&] {
      to_end("settings", record("settings", {"--input", "webcam 0", "--size", "640x360", "--frame-rate", "30", "--gain",
                                             "7", "--control", "brightness=0x80", "--control", "horizontal_flip=on",
                                             "--control", "Test Pattern=5", "--seconds", "0.5"}));
    });
  }

  std::string folder_;
  std::string recording_;
  std::string model_;
};

}  // namespace
}  // namespace vsfind::test

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: vivid_guest FOLDER RECORDING MODEL\n";
    return 2;
  }
  vsfind::test::Guest(argv[1], argv[2], argv[3]).run();
}
