/// `vsfind live` on a GigE camera for as long as one likes, with faults at random: lost packets, the camera killed,
/// held or pulled out, a slow disk, a full disk, the machine standing still. Checks that every row and every recorded
/// frame is whole and right, that every gap is one that vsfind tells of, that memory does not grow, and how it ends.
/// Exits with 1 where anything was wrong, 77 where this machine does not let it. Under `tests/run asan` it is the
/// sanitizers' soak.

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <memory>
#include <mutex>
#include <random>
#include <thread>

#include "tests/acquisition/gige_network.h"
#include "tests/app/scene.h"
#include "tests/soak/ledger.h"
#include "tests/soak/slow_reader.h"
#include "tests/soak/small_disk.h"

namespace vsfind::test {
namespace {

using Clock = std::chrono::steady_clock;

struct Request {
  double seconds = 60.0;
  double session = 0.0;
  double rate = 25.0;
  std::uint64_t seed = 1;
  bool record = false;
};

class Soak {
 public:
  explicit Soak(const Request& request) : request_(request), random_(request.seed) {}

  int run() {
    if (std::string why = enter_own_network(); !why.empty()) return skipped(why);
    std::string why;
    const SmallDisk disk(disk_folder_.path(), disk_bytes, why);
    if (!why.empty()) return skipped(why);
    disk_ = &disk;
    if (part_.training().code != 0) throw std::runtime_error(part_.training().err);
    std::vector<cv::Mat> frames;
    for (int i = 0; i < 8; ++i) frames.push_back(i == 5 ? scene_without_part() : scene(60 + 7 * i, 50 + 5 * i));
    write_y4m(served_, frames, 'p');
    bool all_well = true;
    const auto end = Clock::now() + seconds(request_.seconds);
    while (Clock::now() + std::chrono::seconds(2) < end) {
      const auto until = request_.session > 0.0 ? std::min(end, Clock::now() + seconds(request_.session)) : end;
      all_well = session(until) && all_well;
    }
    return all_well ? 0 : 1;
  }

 private:
  static constexpr std::uint64_t disk_bytes = std::uint64_t{192} << 20U;

  static std::chrono::milliseconds seconds(double s) { return std::chrono::milliseconds(static_cast<long>(s * 1e3)); }
  static int skipped(const std::string& why) {
    fmt::print(stderr, "soak: skipped: {}\n", why);
    return 77;
  }
  double uniform(double min, double max) { return std::uniform_real_distribution<double>(min, max)(random_); }
  static void wait(double s) { std::this_thread::sleep_for(seconds(s)); }

  std::vector<SoakRow> served_rows() const {
    std::vector<SoakRow> rows;
    const auto text = vsfind({"replay", served_, "--model", part_.model(), "--jsonl", "-"}).out;
    for (const auto& line : lines_of(text)) rows.push_back(row_of_json(line).value());
    if (rows.size() != 8) throw std::runtime_error("the pictures served cannot be searched");
    return rows;
  }

  void start_camera() {
    const double lost = std::array{0.0, 0.001, 0.005, 0.02}[random_() % 4];
    for (int attempt = 0; camera_ == nullptr; ++attempt) {
      try {
        camera_ = std::make_unique<GigeServer>(std::vector<std::string>{"127.0.0.1", "S1", "320x240",
                                                                        fmt::format("{}", request_.rate), "--frames",
                                                                        served_, "--lost", fmt::format("{}", lost)});
      } catch (const std::runtime_error&) {
        if (attempt == 20) throw;
        wait(0.2);  // the address of the one before is not free yet
      }
    }
  }

  /// One fault, its length at random; over when it returns.
  void fault(const Process& process, SlowReader& reader) {
    switch (random_() % 7) {
      case 0:
      case 1:  // a power cut; the camera that comes back loses more packets, or fewer
        camera_.reset();
        wait(uniform(0.1, 3.0));
        start_camera();
        count("camera killed");
        break;
      case 2:
        camera_->signal(SIGSTOP);
        wait(uniform(0.1, 3.0));
        camera_->signal(SIGCONT);
        count("camera held");
        break;
      case 3:
        set_link(false);
        wait(uniform(0.1, 2.0));
        set_link(true);
        count("link down");
        break;
      case 4:
        reader.pause(true);
        wait(uniform(0.1, 4.0));
        reader.pause(false);
        count("slow disk");
        break;
      case 5:
        disk_->fill();
        wait(uniform(0.1, 4.0));
        disk_->make_room();
        count("full disk");
        break;
      default:
        process.kill(SIGSTOP);
        wait(uniform(0.1, 2.0));
        process.kill(SIGCONT);
        count("program held");
        break;
    }
  }

  void count(const std::string& what) { ++faults_[what]; }

  /// Resident memory, MB.
  static double memory_of(const Process& process) {
    std::ifstream file(fmt::format("/proc/{}/statm", process.pid()));
    double size = 0.0;
    double resident = 0.0;
    file >> size >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
  }

  bool session(Clock::time_point end) {
    const TemporaryFolder pipes;
    Ledger ledger(served_rows());
    SlowReader reader(pipes / "rows.jsonl", [&](const std::string& line) { ledger.add(line); });
    const std::string csv = disk_folder_ / "rows.csv";
    const std::string recording = disk_folder_ / "rec.y4m";
    std::vector<std::string> words{"live",
                                   "--verbose",  // tells what the camera library complains of
                                   "--source",
                                   "gige:127.0.0.1",
                                   "--model",
                                   part_.model(),
                                   "--jsonl",
                                   pipes / "rows.jsonl",
                                   "--csv",
                                   csv,
                                   "--frame-timeout",
                                   "1",
                                   "--packet-resend",
                                   random_() % 2 == 0 ? "on" : "off"};
    if (request_.record) words.insert(words.end(), {"--record", recording});
    camera_.reset();
    start_camera();
    faults_.clear();
    const auto begin = Clock::now();
    Process process(words);
    std::vector<double> memory;
    auto next_sample = begin + std::chrono::seconds(10);
    while (Clock::now() < end) {
      wait(std::min(uniform(0.2, 4.0), std::chrono::duration<double>(end - Clock::now()).count()));
      if (Clock::now() < end) fault(process, reader);
      if (Clock::now() < next_sample) continue;
      next_sample += std::chrono::seconds(10);
      memory.push_back(memory_of(process));
    }
    process.kill(SIGTERM);
    const Outcome outcome = process.wait();
    std::string problem;
    if (const std::string rest = reader.finish(); !rest.empty()) problem = "the pipe ends within a line: " + rest;
    ledger.compare_csv(read_file(csv));
    if (request_.record) ledger.compare_recording(recording, served_);
    ledger.settle(outcome.err, outcome.code);
    // The first minutes fill caches and the sanitizer's quarantine.
    if (problem.empty() && memory.size() > 30) {
      const auto third = static_cast<std::ptrdiff_t>(memory.size() / 3);
      const double early = *std::max_element(memory.begin() + third, memory.begin() + 2 * third);
      const double late = *std::max_element(memory.begin() + 2 * third, memory.end());
      if (late > early * 1.05 + 4.0) problem = fmt::format("memory grows: {:.1f} MB, then {:.1f} MB", early, late);
    }
    fmt::print("{:.0f} s: {}", std::chrono::duration<double>(Clock::now() - begin).count(), ledger.text());
    for (const auto& [what, times] : faults_) fmt::print(", {} {} times", what, times);
    if (!memory.empty()) fmt::print("; memory {:.1f} MB at first, {:.1f} MB at last", memory.front(), memory.back());
    fmt::print("\n");
    for (const auto& text : ledger.faults()) fmt::print("  FAULT: {}\n", text);
    if (!problem.empty()) fmt::print("  FAULT: {}\n", problem);
    const bool well = problem.empty() && ledger.faults().empty();
    if (!well) fmt::print("{}", outcome.err);
    std::fflush(stdout);
    return well;
  }

  Request request_;
  std::mt19937_64 random_;
  const TemporaryFolder disk_folder_;
  const SmallDisk* disk_ = nullptr;
  const TrainedPart part_;
  const std::string served_ = part_ / "served.y4m";
  std::unique_ptr<GigeServer> camera_;
  std::map<std::string, int> faults_;
};

}  // namespace
}  // namespace vsfind::test

int main(int argc, char** argv) {
  CLI::App app("Lets vsfind live run on a camera with faults at random, and checks that nothing is lost unnoticed.");
  vsfind::test::Request request;
  app.add_option("--seconds", request.seconds, "how long in all (default 60)")->check(CLI::Range(3.0, 1e6));
  app.add_option("--session", request.session, "end and start the program anew every so many seconds (default: never)");
  app.add_option("--rate", request.rate, "frames per second (default 25)")->check(CLI::Range(1.0, 500.0));
  app.add_option("--seed", request.seed, "of the faults (default 1)");
  app.add_flag("--record", request.record, "record the frames, too; the disk has 192 MB");
  CLI11_PARSE(app, argc, argv);
  try {
    return vsfind::test::Soak(request).run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "soak: {}\n", error.what());
    return 1;
  }
}
