// The GigE backend against a real server over GVCP and GVSP.

#include <gmock/gmock.h>

#include <chrono>
#include <cstring>
#include <map>
#include <thread>

#include "acquisition/errors.h"
#include "acquisition/gige_pixels.h"
#include "acquisition/gige_source.h"
#include "acquisition/reconnecting_source.h"
#include "acquisition/recording.h"
#include "tests/acquisition/gige_network.h"
#include "tests/acquisition/gige_picture.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using test::complaint;
using test::GigeServer;
using testing::AllOf;
using testing::HasSubstr;
using testing::SizeIs;

class Gige : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = test::enter_own_network(); !why.empty()) GTEST_SKIP() << why;
  }
};

/// Whether a good frame's bytes are those of the id that it shows.
bool is_exact(const Frame& frame, std::uint32_t& id) {
  const ImageView& image = frame.image();
  const auto bytes =
      static_cast<std::size_t>(image.width * image.bytes_per_pixel()) * static_cast<std::size_t>(image.height);
  std::vector<std::byte> expected(bytes);
  id = test::number_shown(image.data);
  test::fill_numbered(expected.data(), bytes, id);
  return std::memcmp(expected.data(), image.data, bytes) == 0;
}

TEST_F(Gige, EveryFrameThatArrivesIsExactAndCountedPastTheWrapOfItsId) {
  const GigeServer server({"127.0.0.1", "A1", "320x240", "300"});
  const auto source = open_gige("127.0.0.1", {});
  EXPECT_EQ(source->info().name, "gige:127.0.0.1");
  EXPECT_EQ(source->info().width, 320);
  EXPECT_EQ(source->info().height, 240);
  EXPECT_TRUE(source->info().live);
  EXPECT_NEAR(source->info().frame_rate.value(), 300.0, 1.0);
  std::optional<std::uint64_t> first;
  std::uint64_t good = 0;
  std::uint64_t last = 0;
  bool wrapped = false;
  std::int64_t stamp = 0;
  while (last < 220) {
    const auto frame = source->next();
    ASSERT_TRUE(frame);
    last = frame->info().sequence;
    if (frame->info().status != FrameStatus::good) continue;
    ++good;
    std::uint32_t id = 0;
    ASSERT_TRUE(is_exact(*frame, id)) << last;
    wrapped = wrapped || id < 1000;
    const std::uint64_t unwrapped = id < 1000 ? id + 65535 : id;
    if (!first) first = unwrapped - last;
    EXPECT_EQ(unwrapped - last, *first);
    EXPECT_GT(frame->info().timestamp_ns, stamp);
    stamp = frame->info().timestamp_ns;
    EXPECT_EQ(frame->info().clock, Clock::device);
  }
  EXPECT_TRUE(wrapped);
  EXPECT_GT(good, 100U);
  EXPECT_THAT(source->statistics(), AllOf(HasSubstr("frames complete"), HasSubstr("packets missing")));
  // A frame outlives its source.
  auto frame = source->next();
  source->stop();
  EXPECT_FALSE(source->next());
}

TEST_F(Gige, AFrameOutlivesItsSource) {
  const GigeServer server({"127.0.0.1", "A1", "64x48", "100"});
  auto source = open_gige("127.0.0.1", {});
  std::optional<Frame> frame;
  do {
    frame = source->next();
    ASSERT_TRUE(frame);
  } while (frame->info().status != FrameStatus::good);
  source.reset();
  std::uint32_t id = 0;
  EXPECT_TRUE(is_exact(*frame, id));
}

TEST_F(Gige, EveryPixelFormatGivesItsLuma) {
  const GigeServer server({"127.0.0.1", "A1", "128x96", "60"});
  for (const auto& [format, number] :
       {std::pair{"Mono8", 0x01080001U}, std::pair{"Mono16", 0x01100007U}, std::pair{"Mono12", 0x01100005U},
        std::pair{"Mono12Packed", 0x010C0006U}, std::pair{"Mono10p", 0x010A0046U}, std::pair{"RGB8", 0x02180014U},
        std::pair{"BayerRG8", 0x01080009U}, std::pair{"BayerGB8", 0x0108000AU}}) {
    SCOPED_TRACE(format);
    CameraSettings settings;
    settings.pixel_format = format;
    const auto source = open_gige("127.0.0.1", settings);
    const auto pixels = gige_pixels(number);
    ASSERT_TRUE(pixels);
    EXPECT_EQ(source->info().bits, pixels->bits);
    int good = 0;
    for (int i = 0; i < 100 && good < 2; ++i) {
      const auto frame = source->next();
      ASSERT_TRUE(frame);
      if (frame->info().status != FrameStatus::good) continue;
      // The id that was sent: two thousand are tried, since the luma does not show it everywhere.
      std::vector<std::byte> sent(pixels->bytes(128, 96));
      std::vector<std::byte> luma(128 * 96 * 2);
      bool found = false;
      for (std::uint32_t k = 0; k < 2000 && !found; ++k) {
        const std::uint32_t id = k < 1000 ? 65401 + k : k - 999;
        test::fill_numbered(sent.data(), sent.size(), id);
        found = test::same_pixels(luma_from_gige(*pixels, sent.data(), 128, 96, 0, luma.data()), frame->image());
      }
      EXPECT_TRUE(found);
      ++good;
    }
    EXPECT_EQ(good, 2);
  }
}

TEST_F(Gige, RegionExposureGainRateAndFeaturesAreSet) {
  const GigeServer server({"127.0.0.1", "A1", "640x480", "20"});
  CameraSettings settings;
  settings.width = 200;
  settings.height = 100;
  settings.offset_x = 40;
  settings.offset_y = 20;
  settings.frame_rate = 50;
  settings.exposure_us = 1000;
  settings.gain = 3;
  settings.controls = {{"TestBoolean", "true"}, {"TestRegister", "0x10"}, {"AcquisitionMode", "Continuous"}};
  const auto source = open_gige("", settings);
  EXPECT_EQ(source->info().name, "gige:");
  EXPECT_EQ(source->info().width, 200);
  EXPECT_EQ(source->info().height, 100);
  EXPECT_NEAR(source->info().frame_rate.value(), 50.0, 0.5);
  ASSERT_TRUE(source->next());
}

TEST_F(Gige, WhatTheCameraCannotDoIsRefusedWithWhatItCan) {
  const GigeServer server({"127.0.0.1", "A1", "640x480", "20"});
  const auto refused = [](auto change) {
    CameraSettings settings;
    change(settings);
    return complaint<UsageError>([&] { static_cast<void>(open_gige("127.0.0.1", settings)); });
  };
  EXPECT_THAT(refused([](auto& s) { s.pixel_format = "Mono9"; }),
              AllOf(HasSubstr("gige:127.0.0.1: "), HasSubstr("'Mono9'"), HasSubstr("Mono8"), HasSubstr("Mono16")));
  EXPECT_THAT(refused([](auto& s) { s.pixel_format = "Jpeg"; }), AllOf(HasSubstr("luma"), HasSubstr("Mono8")));
  EXPECT_THAT(refused([](auto& s) { s.width = 5000; }), AllOf(HasSubstr("width 5000"), HasSubstr("2048")));
  EXPECT_THAT(refused([](auto& s) { s.exposure_us = 1e12; }), AllOf(HasSubstr("exposure"), HasSubstr("allowed")));
  EXPECT_THAT(refused([](auto& s) { s.trigger = "Line7"; }),
              AllOf(HasSubstr("'Line7'"), HasSubstr("off, Line0, Software")));
  EXPECT_THAT(refused([](auto& s) { s.packet_size = 100'000; }), AllOf(HasSubstr("100000"), HasSubstr("65536")));
  EXPECT_THAT(refused([](auto& s) { s.controls = {{"Nonsense", "1"}}; }), HasSubstr("feature Nonsense"));
  EXPECT_THAT(refused([](auto& s) { s.controls = {{"TestRegister", "1x"}}; }), HasSubstr("'1x' is not a whole number"));
  EXPECT_THAT(refused([](auto& s) {
                s.controls = {{"GainAuto", "Maybe"}};
              }),
              AllOf(HasSubstr("'Maybe'"), HasSubstr("Off, Once, Continuous")));
}

TEST_F(Gige, CamerasAreListedAndFoundByNameSerialAndAddress) {
  const GigeServer one({"10.9.0.1", "ONE", "64x48", "50"});
  const GigeServer two({"10.9.0.2", "TWO", "80x60", "50"});
  const auto cameras = list_gige();
  ASSERT_THAT(cameras, SizeIs(2));
  std::string name;
  for (const auto& camera : cameras) {
    EXPECT_EQ(camera.vendor, "Aravis");
    EXPECT_EQ(camera.problem, "");
    if (camera.serial == "TWO") {
      EXPECT_EQ(camera.address, "10.9.0.2");
      name = camera.uri.substr(5);
    }
    EXPECT_GT(camera.formats.size(), 8U);
    for (const auto& format : camera.formats) {
      if (format.name == "Mono8") {
        EXPECT_TRUE(format.direct);
      }
      ASSERT_THAT(format.sizes, SizeIs(1));
      EXPECT_EQ(format.sizes[0].max_width, 2048);
    }
  }
  EXPECT_EQ(open_gige(name, {})->info().width, 80);
  EXPECT_EQ(open_gige("TWO", {})->info().width, 80);
  EXPECT_EQ(open_gige("TWO", {})->info().width, 80);  // by the name that was learnt
  EXPECT_EQ(open_gige("10.9.0.1", {})->info().width, 64);
  EXPECT_THAT(complaint<CameraError>([] { static_cast<void>(open_gige("THREE", {})); }),
              AllOf(HasSubstr("gige:THREE"), HasSubstr("ONE"), HasSubstr("TWO")));
}

TEST_F(Gige, ACameraThatAnotherProgramHoldsIsSaidToBeHeld) {
  const GigeServer server({"127.0.0.1", "A1", "64x48", "50"});
  const auto first = open_gige("127.0.0.1", {});
  EXPECT_THAT(complaint<CameraError>([] { static_cast<void>(open_gige("127.0.0.1", {})); }),
              HasSubstr("another program holds the camera"));
  ASSERT_TRUE(first->next());
}

TEST_F(Gige, ASoftwareTriggerGivesAFrameEach) {
  const GigeServer server({"127.0.0.1", "A1", "64x48", "100"});
  CameraSettings settings;
  settings.trigger = "software";
  settings.trigger_rate = 50;
  const auto source = open_gige("127.0.0.1", settings);
  int good = 0;
  for (int i = 0; i < 10; ++i) good += source->next()->info().status == FrameStatus::good ? 1 : 0;
  EXPECT_GT(good, 5);
}

TEST_F(Gige, LostPacketsMakeIncompleteFramesAndNoWrongOnes) {
  const GigeServer server({"127.0.0.1", "A1", "320x240", "100", "--lost", "0.05"});
  CameraSettings settings;
  settings.packet_resend = false;
  settings.packet_size = 1500;
  const auto source = open_gige("127.0.0.1", settings);
  int incomplete = 0;
  std::uint64_t last = 0;
  for (int i = 0; i < 60; ++i) {
    const auto frame = source->next();
    ASSERT_TRUE(frame);
    EXPECT_GE(frame->info().sequence, last);
    last = frame->info().sequence;
    std::uint32_t id = 0;
    if (frame->info().status == FrameStatus::good) {
      EXPECT_TRUE(is_exact(*frame, id));
    } else {
      EXPECT_EQ(frame->info().status, FrameStatus::incomplete);
      ++incomplete;
    }
  }
  EXPECT_GT(incomplete, 30);  // of 53 packets, all arrive in 7 frames of 100
}

TEST_F(Gige, PacketsThatThePathCutsMakeNoWrongFrames) {
  struct WholeAgain {
    ~WholeAgain() { test::set_mtu(65536); }
  } at_the_end;
  const GigeServer server({"127.0.0.1", "A1", "320x240", "100"});
  for (const bool past_the_kernel : {true, false}) {
    SCOPED_TRACE(past_the_kernel);
    test::set_mtu(65536);
    CameraSettings settings;
    settings.packet_size = 9000;
    if (!past_the_kernel) settings.packet_socket = false;
    settings.packet_resend = false;
    const auto source = open_gige("127.0.0.1", settings);
    int good_before = 0;
    int others_after = 0;
    for (int i = 0; i < 60; ++i) {
      if (i == 20) test::set_mtu(1500);  // as if a cable went through another switch now
      const auto frame = source->next();
      ASSERT_TRUE(frame);
      std::uint32_t id = 0;
      if (frame->info().status == FrameStatus::good) {
        EXPECT_TRUE(is_exact(*frame, id)) << i;
        if (i < 20) ++good_before;
      } else if (i > 25) {
        ++others_after;
      }
    }
    EXPECT_GT(good_before, 5);
    // The kernel puts the pieces together again; past it they cannot be told from whole packets but by their size.
    if (past_the_kernel) {
      EXPECT_GT(others_after, 10);
    }
  }
}

TEST_F(Gige, AHardwareTriggerMayWaitForEver) {
  const GigeServer server({"127.0.0.1", "A1", "64x48", "100"});
  CameraSettings settings;
  settings.trigger = "Line0";
  settings.frame_timeout_s = 0.1;
  const auto source = open_gige("127.0.0.1", settings);
  EXPECT_FALSE(source->info().frame_rate.known());
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    source->stop();
  });
  EXPECT_FALSE(source->next());  // no trigger came, and none is missed
  later.join();
}

/// Frames of an interlaced camera against the recording that it shows.
class GigeInterlaced : public Gige {
 protected:
  void SetUp() override {
    Gige::SetUp();
    SourceInfo info;
    info.width = 64;
    info.height = 48;
    RecordingWriter writer(folder_.file("f.y4m"), info);
    for (std::uint32_t i = 0; i < 4; ++i) {
      frames_.emplace_back(64, 48, 8, i);
      writer.append(frames_.back().view(), {});
    }
  }
  /// How many frames of the mode are a field (or all) of a frame of the recording.
  void expect_frames(const std::string& mode, Field field) {
    SCOPED_TRACE(mode);
    CameraSettings settings;
    settings.height = 48;
    settings.controls = {{"FieldOutputMode", mode}};
    const auto source = open_gige("127.0.0.1", settings);
    EXPECT_EQ(source->info().height, 48);
    EXPECT_EQ(source->info().order, FieldOrder::top_first);
    int good = 0;
    for (int i = 0; i < 100 && good < 4; ++i) {
      const auto frame = source->next();
      ASSERT_TRUE(frame);
      if (frame->info().status != FrameStatus::good) continue;
      ++good;
      EXPECT_EQ(frame->info().field, field);
      EXPECT_TRUE(std::any_of(frames_.begin(), frames_.end(), [&](const test::Picture& picture) {
        return test::same_pixels(field_view(picture.view(), field), frame->image());
      }));
    }
    EXPECT_EQ(good, 4);
  }

  test::TemporaryFolder folder_;
  std::vector<test::Picture> frames_;
};

TEST_F(GigeInterlaced, EveryModeGivesItsFields) {
  const GigeServer server({"127.0.0.1", "A1", "64x48", "100", "--interlaced", "--frames", folder_.file("f.y4m")});
  expect_frames("DeinterlacedNewFields", Field::frame);
  expect_frames("ConcatenatedNewFields", Field::frame);
  expect_frames("Field0", Field::top);
  expect_frames("Field1", Field::bottom);
  CameraSettings settings;
  settings.height = 47;
  settings.controls = {{"FieldOutputMode", "Field0"}};
  EXPECT_THAT(complaint<UsageError>([&] { static_cast<void>(open_gige("127.0.0.1", settings)); }),
              HasSubstr("47 rows (allowed: an even number)"));
  settings.controls = {{"FieldOutputMode", "ConcatenatedNewFields"}};
  settings.height = 48;
  settings.field_order = "interlaced-bt";
  EXPECT_EQ(open_gige("127.0.0.1", settings)->info().order, FieldOrder::bottom_first);
  settings.controls = {{"DeviceScanType", "Progressive"}};
  EXPECT_EQ(open_gige("127.0.0.1", settings)->info().order, FieldOrder::progressive);
}

/// Fields one after the other: which one a picture is follows from its id, through lost ones and the id's wrap after
/// 135 fields.
class GigeFieldsInTurn : public GigeInterlaced {
 protected:
  void expect_fields(const std::vector<std::string>& more, const CameraSettings& settings, Field first) {
    std::vector<std::string> arguments{"127.0.0.1",          "A1", "64x48", "200", "--interlaced", "--frames",
                                       folder_.file("f.y4m")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const GigeServer server(arguments);
    const auto source = open_gige("127.0.0.1", settings);
    EXPECT_EQ(source->info().height, 48);
    EXPECT_EQ(source->info().order, first == Field::top ? FieldOrder::top_first : FieldOrder::bottom_first);
    std::map<Field, int> good;
    std::uint64_t last = 0;
    std::optional<std::size_t> begin;  // which frame of the recording was the first
    while (last < 120) {
      const auto frame = source->next();
      ASSERT_TRUE(frame);
      const FrameInfo& info = frame->info();
      last = info.sequence;
      ASSERT_NE(info.field, Field::frame);
      if (info.status != FrameStatus::good) continue;
      ++good[info.field];
      std::optional<std::size_t> shown;
      // The server's first field is the top one's rows.
      const Field sent = (info.field == first) ? Field::top : Field::bottom;
      for (std::size_t i = 0; i < frames_.size(); ++i) {
        if (test::same_pixels(field_view(frames_[i].view(), sent), frame->image())) shown = i;
      }
      ASSERT_TRUE(shown) << "frame " << info.sequence << " is not the " << name(info.field) << " field of any";
      const std::size_t start = (*shown + 4 - info.sequence % 4) % 4;
      if (!begin) begin = start;
      ASSERT_EQ(start, *begin) << "frame " << info.sequence << " has the number of another";
    }
    EXPECT_GT(good[Field::top], 20);
    EXPECT_GT(good[Field::bottom], 20);
  }
};

TEST_F(GigeFieldsInTurn, AreToldApart) {
  CameraSettings settings;
  settings.height = 48;
  settings.controls = {{"FieldOutputMode", "Field0First"}};
  expect_fields({}, settings, Field::top);
  settings.field_order = "interlaced-bt";
  expect_fields({}, settings, Field::bottom);
}

TEST_F(GigeFieldsInTurn, AreToldApartWhereSomeAreLost) {
  CameraSettings settings;
  settings.height = 48;
  settings.controls = {{"FieldOutputMode", "Field0First"}};
  settings.packet_size = 576;
  settings.packet_resend = false;
  expect_fields({"--lost", "0.1"}, settings, Field::top);
}

/// A source that reopens its camera, and what it told.
class GigeFaults : public Gige {
 protected:
  void open() {
    CameraSettings settings;
    settings.frame_timeout_s = 0.5;
    source_ = open_reconnecting("gige:127.0.0.1", [settings] { return open_gige("127.0.0.1", settings); });
    source_->on_event([this](const SourceEvent& event) {
      if (event.kind == SourceEvent::Kind::fault) ++faults_;
      if (event.kind == SourceEvent::Kind::recovered) ++recoveries_;
    });
  }
  void read(int frames) {
    for (int i = 0; i < frames; ++i) {
      const auto frame = source_->next();
      ASSERT_TRUE(frame);
      if (frame->info().status != FrameStatus::good) continue;
      std::uint32_t id = 0;
      EXPECT_TRUE(is_exact(*frame, id));
      EXPECT_TRUE(!last_ || frame->info().sequence > *last_);
      last_ = frame->info().sequence;
    }
  }

  std::unique_ptr<FrameSource> source_;
  std::optional<std::uint64_t> last_;
  int faults_ = 0;
  int recoveries_ = 0;
};

TEST_F(GigeFaults, AnAbsentCameraIsWaitedForAndAKilledOneComesBack) {
  open();
  std::unique_ptr<GigeServer> server;
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    server = std::make_unique<GigeServer>(std::vector<std::string>{"127.0.0.1", "A1", "64x48", "100"});
  });
  read(10);
  later.join();
  // The first attempt may have waited long enough for it: then nothing is told.
  EXPECT_EQ(faults_, recoveries_);
  faults_ = recoveries_ = 0;
  server->kill();
  std::chrono::steady_clock::time_point back;
  later = std::thread([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    server = std::make_unique<GigeServer>(std::vector<std::string>{"127.0.0.1", "A1", "64x48", "100"});
    back = std::chrono::steady_clock::now();
  });
  const std::uint64_t before = *last_;
  while (faults_ < 1) read(1);  // what was on its way, then the first frame after the return
  const auto returned = std::chrono::steady_clock::now();
  later.join();
  EXPECT_EQ(faults_, 1);
  EXPECT_EQ(recoveries_, 1);
  EXPECT_GE(*last_, before + 60);  // it was away for 1.5 s, 150 frames where the server keeps its rate
  EXPECT_LE(*last_, before + 100 * 20);
  const double seconds = std::chrono::duration<double>(returned - back).count();
  RecordProperty("seconds_to_return", std::to_string(seconds));
  EXPECT_LT(seconds, 2.0);  // 0.7 s, on a busy machine, too
  read(10);
  EXPECT_THAT(source_->statistics(), HasSubstr("reopened 1 times"));
  source_.reset();  // before the camera: one that is gone costs seconds of asking it to stop
}

TEST_F(GigeFaults, ALinkThatWasDownComesBack) {
  const GigeServer server({"127.0.0.1", "A1", "64x48", "100"});
  open();
  read(10);
  test::set_link(false);
  std::thread later([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    test::set_link(true);
  });
  while (faults_ < 1) read(1);
  later.join();
  read(10);
  EXPECT_EQ(faults_, 1);
  EXPECT_EQ(recoveries_, 1);
  source_.reset();
}

TEST_F(GigeFaults, StopEndsTheWaitForAnAbsentCamera) {
  open();
  std::thread later([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    source_->stop();
  });
  EXPECT_FALSE(source_->next());
  later.join();
}

}  // namespace
}  // namespace vsfind
