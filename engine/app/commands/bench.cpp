// typodont bench: error against time, part by part, each beside its baselines measured in the same run.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "audio/bench.h"
#include "calibration/bench.h"
#include "engine/app/commands/commands.h"
#include "engine/app/scene.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/debris/bench.h"
#include "engine/surface/bench.h"
#include "haptics/bench.h"

namespace typodont {

namespace {

/// One row of the table every part's rows are put into.
struct Row {
  std::string part, name, knob;
  double error = std::nan("");  // NaN: nothing to compare with
  std::string error_unit;
  double time_ns = 0;
  std::string per, baseline;
  double ratio = std::nan("");
};

std::vector<Row> sound_rows(bool quick) {
  audio::BenchOptions options;
  options.recording = assets_folder() / "sounds/micromotor_steady.wav";
  if (quick) options.orders = {16, 300}, options.repeats = 3;
  std::vector<Row> rows;
  for (const audio::BenchRow& r : audio::audio_bench(options)) {
    rows.push_back({"sound", r.name, r.knob, r.error_unit.empty() ? std::nan("") : r.error, r.error_unit, r.time_ns,
                    "sample", r.baseline, r.baseline.empty() ? std::nan("") : r.ratio});
  }
  return rows;
}

std::vector<Row> calibration_rows(bool quick) {
  std::vector<Row> rows;
  for (const calibration::BenchRow& r : calibration::bench_rows(quick)) {
    rows.push_back({"calibration", r.task + ", " + r.method, fmt::format("{} touches", r.touches), r.error, r.error_unit,
                    r.time_us * 1e3, "solution", "", std::nan("")});
  }
  return rows;
}

std::vector<Row> surface_rows(bool quick) {
  surface::BenchOptions options;
  if (quick) options.repeats = 3;
  std::vector<Row> rows;
  for (const surface::BenchRow& r : surface::bench_sphere(options)) {
    rows.push_back({"surface", r.name, r.knob, r.error, r.error_unit, r.time_ns, r.per, r.baseline,
                    r.baseline.empty() ? std::nan("") : r.ratio});
  }
  return rows;
}

std::vector<Row> debris_rows(bool quick) {
  debris::BenchOptions options;
  if (quick) options.repeats = 50;
  std::vector<Row> rows;
  for (const debris::BenchRow& r : debris::bench_debris(options)) {
    rows.push_back({"debris", r.name, r.knob, std::nan(""), "", r.time_ns, "step", r.baseline,
                    r.baseline.empty() ? std::nan("") : r.ratio});
  }
  return rows;
}

std::vector<Row> contact_rows(bool quick) {
  haptics::BenchOptions options;
  if (quick) options.ticks = 300, options.voxels_mm = {0.2, 0.1};
  std::vector<Row> rows;
  for (const haptics::BenchRow& r : haptics::bench_contact(options)) {
    rows.push_back({"contact", r.name, r.knob, r.error_unit.empty() ? std::nan("") : r.error, r.error_unit, r.time_ns,
                    r.per, r.baseline, r.baseline.empty() ? std::nan("") : r.ratio});
  }
  return rows;
}

struct Part {
  const char* name;
  std::vector<Row> (*rows)(bool quick);
};
constexpr Part kParts[] = {{"contact", contact_rows},
                           {"surface", surface_rows},
                           {"debris", debris_rows},
                           {"sound", sound_rows},
                           {"calibration", calibration_rows}};

std::string cell(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : ""; }
std::string quoted(const std::string& text) {
  return text.find_first_of(",\"") == std::string::npos ? text : fmt::format("\"{}\"", text);
}

/// The machine, compiler and date, so that a row can be compared with another of its kind.
std::string header() {
  std::string cpu = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) {
      cpu = line.substr(line.find(':') + 2);
      break;
    }
  }
  const std::time_t now = std::time(nullptr);
  char date[32];
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
  return fmt::format("# typodont {}, {}, {} cores, {}, GCC {}\n", TYPODONT_VERSION, cpu,
                     std::thread::hardware_concurrency(), date, __VERSION__);
}

struct Options {
  std::vector<std::string> names;
  std::string out;
  bool quick = false, json = false;
};

void run(const Options& options) {
  std::vector<Row> rows;
  for (const Part& part : kParts) {
    if (!options.names.empty() && std::find(options.names.begin(), options.names.end(), part.name) == options.names.end()) continue;
    log::info("measuring {}", part.name);
    const auto more = part.rows(options.quick);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  if (!options.out.empty()) {
    std::string csv = header() + "part,case,knob,error,error_unit,time_ns,per,baseline,ratio\n";
    for (const Row& r : rows) {
      csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", r.part, quoted(r.name), quoted(r.knob), cell(r.error),
                         quoted(r.error_unit), cell(r.time_ns), r.per, quoted(r.baseline), cell(r.ratio));
    }
    write_file_atomically(options.out, csv);
  }
  if (options.json) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    const auto number = [](double v) { return std::isfinite(v) ? nlohmann::ordered_json(v) : nlohmann::ordered_json(); };
    for (const Row& r : rows) {
      json.push_back({{"part", r.part}, {"case", r.name}, {"knob", r.knob}, {"error", number(r.error)},
                      {"error_unit", r.error_unit}, {"time_ns", number(r.time_ns)}, {"per", r.per},
                      {"baseline", r.baseline}, {"ratio", number(r.ratio)}});
    }
    fmt::print("{}\n", json.dump(1));
    return;
  }
  fmt::print("{:<12} {:<44} {:<20} {:>12} {:<28} {:>12} {:<9} {:>8} {}\n", "part", "case", "knob", "error", "unit",
             "time, ns", "per", "ratio", "to");
  for (const Row& r : rows) {
    fmt::print("{:<12} {:<44} {:<20} {:>12} {:<28} {:>12} {:<9} {:>8} {}\n", r.part, r.name, r.knob, cell(r.error),
               r.error_unit, cell(r.time_ns), r.per, std::isfinite(r.ratio) ? fmt::format("{:.2f}", r.ratio) : "", r.baseline);
  }
}

}  // namespace

void add_bench_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("bench", "Measure error against time, part by part, beside baselines");
  command->footer("Example:\n  typodont bench surface sound --out bench.csv");
  std::vector<std::string> names;
  for (const Part& part : kParts) names.emplace_back(part.name);
  command->add_option("name", options->names, "parts to measure; all when none is named")->check(CLI::IsMember(names));
  command->add_option("--out", options->out, "write the rows as CSV, with machine, compiler and date");
  command->add_flag("--quick", options->quick, "fewer repeats: a look, not a measurement");
  command->add_flag("--json", options->json, "print the rows as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
