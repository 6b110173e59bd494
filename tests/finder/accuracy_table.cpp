/// Prints the whole table of what the finder must show, each row measured on rendered scenes of exactly known pose.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>

#include "rows.h"
#include "stage.h"

int main(int argc, char** argv) {
  using namespace vsfind::measure;
  CLI::App app("Measures the finder on rendered scenes of exactly known pose, a row for each difficulty.");
  std::vector<std::string> wanted;
  Settings settings;
  bool list = false;
  app.add_option("--rows", wanted, "only rows whose name contains one of these texts (e.g. --rows translation hidden)");
  app.add_option("--scenes", settings.scenes, "scenes in each row of random scenes (default 200)")
      ->check(CLI::Range(2, 100000));
  app.add_option("--seed", settings.seed, "seed of the whole table (default 1)");
  app.add_option("--noise", settings.noise,
                 "noise of the calibrated rows, in the training picture, too, grey levels (default 2)")
      ->check(CLI::Range(0.0, 50.0));
  app.add_option("--dump", dump_folder, "folder for a picture of every failed scene: truth green, found red");
  app.add_flag("--list", list, "print the names of the rows");
  CLI11_PARSE(app, argc, argv);

  std::vector<Entry> entries = accuracy_rows();
  for (auto* more : {&robust_rows, &trust_rows, &calibrated_rows}) {
    for (Entry& entry : (*more)()) entries.push_back(std::move(entry));
  }
  if (list) {
    for (const Entry& entry : entries) fmt::print("{}\n", entry.name);
    return 0;
  }
  int failed = 0;
  int measured = 0;
  print_header();
  for (const Entry& entry : entries) {
    const auto contains = [&](const std::string& text) { return entry.name.find(text) != std::string::npos; };
    if (!wanted.empty() && std::none_of(wanted.begin(), wanted.end(), contains)) continue;
    ++measured;
    try {
      failed += entry.measure(settings) ? 0 : 1;
    } catch (const std::exception& error) {
      fmt::print("{}: FAIL: {}\n", entry.name, error.what());
      ++failed;
    }
  }
  fmt::print("{} of {} reached their targets\n", measured - failed, measured);
  return failed == 0 ? 0 : 1;
}
