#include "app/pipeline.h"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <map>
#include <mutex>
#include <thread>

#include "acquisition/errors.h"
#include "app/signals.h"
#include "finder/model_file.h"
#include "tests/app/scene.h"

namespace vsfind {
namespace {

using test::csv_rows;
using test::read_file;

/// Frames of one and the same picture: some bad, some way to end.
class ScriptedSource final : public FrameSource {
 public:
  ScriptedSource(cv::Mat picture, std::uint64_t count) : picture_(std::move(picture)), count_(count) {
    info_.name = "scripted";
  }
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    std::unique_lock lock(mutex_);
    if (stopped_) return std::nullopt;
    if (sequence_ == count_) {
      if (fails_at_end) throw IoError("scripted: damaged");
      if (!waits_at_end) return std::nullopt;
      stop_.wait(lock, [this] { return stopped_; });
      return std::nullopt;
    }
    FrameInfo info;
    info.sequence = sequence_++;
    if (info.sequence == bad_frame) info.status = FrameStatus::incomplete;
    ImageView view;
    view.data = reinterpret_cast<const std::byte*>(picture_.data);
    view.width = picture_.cols;
    view.height = picture_.rows;
    view.stride = static_cast<std::ptrdiff_t>(picture_.step);
    return Frame(nullptr, 0, view, info);
  }
  void stop() noexcept override {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    stop_.notify_all();
  }
  [[nodiscard]] std::uint64_t given() {
    const std::lock_guard lock(mutex_);
    return sequence_;
  }

  bool fails_at_end = false;
  bool waits_at_end = false;
  std::uint64_t bad_frame = ~std::uint64_t{0};

 private:
  SourceInfo info_;
  cv::Mat picture_;
  std::uint64_t count_;
  std::uint64_t sequence_ = 0;
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopped_ = false;
};

class PipelineTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(part_.training().code, 0) << part_.training().err;
    options_.models = {part_.model()};
    options_.csv = part_ / "rows.csv";
  }
  std::exception_ptr run(ScriptedSource& source, const PipelineOptions& pipeline = {}) {
    FrameSearcher searcher(load_models(options_.models), options_, {});
    ResultOutput output(options_, std::nullopt);
    return run_pipeline(source, searcher, output, signals_, pipeline);
  }
  [[nodiscard]] auto rows() const { return csv_rows(read_file(part_ / "rows.csv")); }

  SignalWatcher signals_;
  test::TrainedPart part_;
  RunOptions options_;
};

TEST_F(PipelineTest, EveryFrameGivesItsRowsInOrder) {
  ScriptedSource source(test::scene(90, 70), 40);
  source.bad_frame = 7;
  EXPECT_FALSE(run(source));
  const auto found = rows();
  ASSERT_EQ(found.size(), 40U);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].at("frame"), std::to_string(i));
    EXPECT_EQ(found[i].at("status"), i == 7 ? "bad_frame" : "found");
    EXPECT_EQ(found[i].at("search_ms").empty(), i == 7);
  }
}

TEST_F(PipelineTest, AFailingSourceCostsNoRowOfItsWholeFrames) {
  ScriptedSource source(test::scene(90, 70), 12);
  source.fails_at_end = true;
  const auto error = run(source);
  ASSERT_TRUE(error);
  EXPECT_THROW(std::rethrow_exception(error), IoError);
  EXPECT_EQ(rows().size(), 12U);
}

TEST_F(PipelineTest, AFailingOutputEndsTheSource) {
  options_.csv = part_ / "rows.csv";
  options_.jsonl = "/dev/full";
  ScriptedSource source(test::scene(90, 70), 1'000'000);
  const auto error = run(source);
  ASSERT_TRUE(error);
  EXPECT_THROW(std::rethrow_exception(error), IoError);
  EXPECT_LT(source.given(), 100U);
}

TEST_F(PipelineTest, AFailingOutputEndsASourceThatWaits) {
  options_.jsonl = "/dev/full";
  ScriptedSource source(test::scene(90, 70), 1);
  source.waits_at_end = true;
  EXPECT_TRUE(run(source));  // a hang is the failure
}

TEST_F(PipelineTest, ASignalEndsItAfterTheFramesInHand) {
  ScriptedSource source(test::scene(90, 70), 3);
  source.waits_at_end = true;
  std::jthread killer([&] {
    while (source.given() < 3) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ::kill(::getpid(), SIGTERM);
  });
  EXPECT_FALSE(run(source));
  EXPECT_EQ(rows().size(), 3U);
}

TEST_F(PipelineTest, NothingIsLostWithoutDropping) {
  ScriptedSource source(test::scene_without_part(), 60);
  EXPECT_FALSE(run(source, {.queue_length = 1, .drop_oldest = false}));
  EXPECT_EQ(rows().size(), 60U);
}

TEST_F(PipelineTest, DroppingCountsWhatItLoses) {
  // A source that gives all at once is faster than any search.
  ScriptedSource source(test::scene(90, 70), 400);
  FrameSearcher searcher(load_models(options_.models), options_, {});
  ResultOutput output(options_, std::nullopt);
  EXPECT_FALSE(run_pipeline(source, searcher, output, signals_, {.queue_length = 2, .drop_oldest = true}));
  const auto found = rows();
  EXPECT_LT(found.size(), 400U);
  EXPECT_EQ(found.back().at("frame"), "399");
  EXPECT_EQ(found.size() + output.summary().dropped, 400U);
}

TEST_F(PipelineTest, EachOfSeveralSourcesKeepsItsOrderAndItsLimit) {
  ScriptedSource one(test::scene(90, 70), 30);
  ScriptedSource two(test::scene_without_part(), 1'000'000);
  FrameSearcher first(load_models(options_.models), options_, {});
  FrameSearcher second(load_models(options_.models), options_, {});
  ResultOutput output(options_, std::nullopt);
  std::vector<Lane> lanes(2);
  lanes[0].source = &one;
  lanes[0].searcher = &first;
  lanes[1].source = &two;
  lanes[1].searcher = &second;
  EXPECT_FALSE(run_pipeline(lanes, output, signals_, {.max_frames = 20}));
  std::map<std::string, std::uint64_t> next;
  for (const auto& row : rows()) EXPECT_EQ(row.at("frame"), std::to_string(next[row.at("status")]++));
  EXPECT_EQ(next, (std::map<std::string, std::uint64_t>{{"found", 20}, {"not_found", 20}}));
}

TEST_F(PipelineTest, AFailingSourceEndsTheOthers) {
  ScriptedSource one(test::scene(90, 70), 3);
  one.fails_at_end = true;
  ScriptedSource two(test::scene_without_part(), 2);
  two.waits_at_end = true;
  FrameSearcher first(load_models(options_.models), options_, {});
  FrameSearcher second(load_models(options_.models), options_, {});
  ResultOutput output(options_, std::nullopt);
  std::vector<Lane> lanes(2);
  lanes[0].source = &one;
  lanes[0].searcher = &first;
  lanes[1].source = &two;
  lanes[1].searcher = &second;
  EXPECT_TRUE(run_pipeline(lanes, output, signals_));
  EXPECT_GE(rows().size(), 3U);
}

TEST_F(PipelineTest, ATimeLimitEndsASourceThatWaits) {
  ScriptedSource source(test::scene(90, 70), 3);
  source.waits_at_end = true;
  EXPECT_FALSE(run(source, {.max_seconds = 0.2}));
  EXPECT_LE(rows().size(), 3U);
}

TEST(SearchedFields, ComeInTheOrderOfExposure) {
  using testing::ElementsAre;
  FrameInfo frame;
  frame.order = FieldOrder::top_first;
  EXPECT_THAT(searched_fields(FieldMode::frame, frame), ElementsAre(Field::frame));
  EXPECT_THAT(searched_fields(FieldMode::split, frame), ElementsAre(Field::top, Field::bottom));
  EXPECT_THAT(searched_fields(FieldMode::bottom, frame), ElementsAre(Field::bottom));
  frame.order = FieldOrder::bottom_first;
  EXPECT_THAT(searched_fields(FieldMode::split, frame), ElementsAre(Field::bottom, Field::top));
  frame.order = FieldOrder::unknown;
  EXPECT_THAT(searched_fields(FieldMode::split, frame), ElementsAre(Field::top, Field::bottom));
  frame.field = Field::bottom;
  EXPECT_THAT(searched_fields(FieldMode::split, frame), ElementsAre(Field::bottom));
  EXPECT_THAT(searched_fields(FieldMode::frame, frame), ElementsAre(Field::bottom));
  EXPECT_THAT(searched_fields(FieldMode::top, frame), ElementsAre());
}

TEST(GreyPicture, DeepPixelsKeepTheirUpperBits) {
  const std::vector<std::uint16_t> pixels{0, 1023, 512, 4};
  ImageView view;
  view.data = reinterpret_cast<const std::byte*>(pixels.data());
  view.width = 2;
  view.height = 2;
  view.stride = 4;
  view.bits = 10;
  EXPECT_THAT(grey_picture(view).pixels, testing::ElementsAre(0, 255, 128, 1));
}

}  // namespace
}  // namespace vsfind
