// The command `typodont bench`: measures error and time of each part, with baselines measured in the same run.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "engine/app/bench/model_anatomies.h"
#include "engine/app/bench/models_page.h"
#include "engine/app/bench/page_text.h"
#include "engine/app/bench/parts.h"
#include "engine/app/bench/performance_page.h"
#include "engine/app/bench/row_origin.h"
#include "engine/app/bench/stored_rows.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/split.h"
#include "haptics/contact_method.h"

namespace typodont {

namespace {

std::string cell(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "";
}
std::string quoted(const std::string& text) {
  return text.find_first_of(",\"") == std::string::npos ? text : fmt::format("\"{}\"", text);
}

/// Returns a text with machine, compiler, flags and date. Times of two rows are comparable only if machine, compiler
/// and flags are equal.
std::string machine() {
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
  const char* const commit = std::getenv("TYPODONT_COMMIT");  // the script ./run bench sets this variable
  return fmt::format("typodont {}{}, {}, {} cores, {}, GCC {}, {}", TYPODONT_VERSION,
                     commit ? fmt::format(" ({})", commit) : "", cpu, std::thread::hardware_concurrency(), date,
                     __VERSION__, TYPODONT_FLAGS);
}

struct Options {
  std::vector<std::string> names;
  std::string out, page, keep, model, tissues;
  bool quick = false, json = false, merge = false;
};

std::string csv(const std::vector<MeasuredPart>& parts, const std::string& made) {
  std::string text = fmt::format("# {}\n{}\n", made, kRowColumns);
  for (const MeasuredPart& m : parts) {
    for (const BenchRow& r : m.rows) {
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", m.part->name, quoted(r.name), quoted(r.knob),
                          cell(r.error), quoted(r.error_unit), cell(r.time_ns), r.per, quoted(r.baseline),
                          cell(r.ratio), cell(r.size), quoted(r.size_unit));
    }
  }
  return text;
}

void print_json(const std::vector<MeasuredPart>& parts) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  const auto number = [](double v) { return std::isfinite(v) ? nlohmann::ordered_json(v) : nlohmann::ordered_json(); };
  for (const MeasuredPart& m : parts) {
    for (const BenchRow& r : m.rows) {
      json.push_back({{"part", m.part->name},
                      {"case", r.name},
                      {"knob", r.knob},
                      {"error", number(r.error)},
                      {"error_unit", r.error_unit},
                      {"time_ns", number(r.time_ns)},
                      {"per", r.per},
                      {"baseline", r.baseline},
                      {"ratio", number(r.ratio)},
                      {"size", number(r.size)},
                      {"size_unit", r.size_unit}});
    }
  }
  fmt::print("{}\n", json.dump(1));
}

void print_table(const std::vector<MeasuredPart>& parts) {
  fmt::print("{:<12} {:<50} {:<28} {:>12} {:<28} {:>12} {:<12} {:>8} {}\n", "part", "case", "parameters", "error",
             "unit", "time, ns", "unit of work", "ratio", "compared with");
  for (const MeasuredPart& m : parts) {
    for (const BenchRow& r : m.rows) {
      fmt::print("{:<12} {:<50} {:<28} {:>12} {:<28} {:>12} {:<12} {:>8} {}\n", m.part->name, r.name, r.knob,
                 cell(r.error), r.error_unit, cell(r.time_ns), r.per,
                 std::isfinite(r.ratio) ? fmt::format("{:.3g}", r.ratio) : "", r.baseline);
    }
  }
}

/// Returns the contact model that the user chose with the option --model; null if the option is missing. Throws Error
/// if a requested part does not measure contact models.
haptics::SharedContactMethod chosen_method(const Options& options) {
  if (options.model.empty()) return nullptr;
  std::vector<std::string> taking;
  for (const BenchPart& part : bench_parts()) {
    if (part.takes_model) taking.emplace_back(part.name);
  }
  for (const std::string& name : options.names) {
    if (std::find(taking.begin(), taking.end(), name) == taking.end())
      throw Error("--model", name, "a part that measures no contact model", fmt::format("{}", fmt::join(taking, ", ")));
  }
  if (options.names.empty())
    throw Error("--model", "parts to measure", "all of them", fmt::format("{}", fmt::join(taking, ", ")));
  return haptics::contact_method(options.model, "--model");
}

/// Returns the tissues of the option --tissues; empty if the option is missing. Throws Error if a name is unknown or if
/// another part than `models` is measured.
std::vector<std::string> chosen_tissues(const Options& options) {
  if (options.tissues.empty()) return {};
  if (options.names != std::vector<std::string>{"models"})
    throw Error("--tissues", "", fmt::format("parts {}", fmt::join(options.names, ", ")), "only the part models");
  const std::vector<std::string> known = compared_tissues();
  std::vector<std::string> chosen;
  for (const std::string_view name : split(options.tissues, ",")) {
    chosen.emplace_back(name);
    if (std::ranges::find(known, chosen.back()) == known.end())
      throw Error("--tissues", "", chosen.back(), fmt::format("{}", fmt::join(known, ", ")));
  }
  return chosen;
}

/// Returns the name under which the first line of a results file states when and where this row was measured. The name
/// is the row's part of the benchmark (for example, `contact`). Only for the part `models`, which measures several
/// tissues, the name is the row's tissue.
std::string name_of_row(std::string_view part, const BenchRow& row) {
  if (part != "models") return std::string(part);
  const std::vector<ModelFigure> figures = model_figures({row});
  return figures.empty() ? std::string(part) : figures.front().tissue;
}

/// The rows of the files of the option --keep, and where they come from.
struct KeptRows {
  std::map<std::string, std::vector<BenchRow>> rows;  // rows of each part of the benchmark, by its name
  std::vector<RowOrigin> origins;
};

/// Reads the files of the option --keep. If several files contain the same part of the benchmark (or the same tissue of
/// the part `models`), the rows of the first of these files are used. Throws Error.
KeptRows kept_rows(const Options& options) {
  KeptRows kept;
  if (options.keep.empty()) return kept;
  const std::vector<std::string_view> files = split(options.keep, ",");
  std::set<std::string> known;
  for (const std::string_view name : files) {
    const std::string file(name);
    std::set<std::string> here;
    std::vector<std::string> in_order;
    for (auto& [part, rows] : stored_rows(file)) {
      for (BenchRow& row : rows) {
        const std::string named = name_of_row(part, row);
        if (known.contains(named)) continue;
        if (here.insert(named).second) in_order.push_back(named);
        kept.rows[part].push_back(std::move(row));
      }
    }
    known.merge(here);
    LineReader in(file, InputKind::kTable);
    std::string first;
    if (!in.next(first) || !first.starts_with("# ")) continue;
    for (RowOrigin& origin : origins_of(first.substr(2))) {
      if (origin.names.empty() && files.size() > 1) origin.names = in_order;
      kept.origins.push_back(std::move(origin));
    }
  }
  return kept;
}

/// Adds the rows of earlier measurements (option --keep) to new rows. `rows`: new rows of the part, measured on
/// `tissues`. `kept`: earlier rows of the same part; those of the tissues in `tissues` are ignored. The result is in
/// the usual order of all tissues.
std::vector<BenchRow> with_kept(std::string_view part, std::vector<BenchRow> rows, const std::vector<BenchRow>& kept,
                                const std::vector<std::string>& tissues) {
  for (const BenchRow& row : kept) {
    if (std::ranges::find(tissues, name_of_row(part, row)) == tissues.end()) rows.push_back(row);
  }
  const std::vector<std::string> order = compared_tissues();
  std::ranges::stable_sort(
      rows, {}, [&](const BenchRow& row) { return std::ranges::find(order, name_of_row(part, row)) - order.begin(); });
  return rows;
}

void run(const Options& options) {
  const BenchRun asked{options.quick, chosen_method(options), chosen_tissues(options)};
  if (!options.page.empty()) require_page(options.page);
  if (options.merge && options.keep.empty()) throw Error("--merge", "", "no option --keep", "tables to merge");
  KeptRows kept = kept_rows(options);
  std::vector<MeasuredPart> measured;
  for (const BenchPart& part : bench_parts()) {
    std::vector<BenchRow>& stored = kept.rows[std::string(part.name)];
    const bool named = options.names.empty() || std::ranges::find(options.names, part.name) != options.names.end();
    if (options.merge || !named) {
      if (named || (!options.merge && !stored.empty()))
        measured.push_back({&part, with_kept(part.name, {}, stored, {})});
      continue;
    }
    log::info("measuring {}", part.name);
    std::vector<BenchRow> rows = part.rows(asked);
    if (!asked.tissues.empty()) rows = with_kept(part.name, std::move(rows), stored, asked.tissues);
    measured.push_back({&part, std::move(rows)});
  }
  // The rows from the files of --keep were measured earlier, perhaps on another machine. So the origins of these rows
  // are kept, too.
  std::vector<RowOrigin> origins = std::move(kept.origins);
  if (!options.merge) {
    const bool all = options.keep.empty() && asked.tissues.empty();
    origins.insert(origins.begin(), {machine() + (options.quick ? ", quick run (--quick), not a measurement" : ""),
                                     all                     ? std::vector<std::string>{}
                                     : asked.tissues.empty() ? options.names
                                                             : asked.tissues});
  }
  const std::string made = text_of(joined(origins));
  if (!options.out.empty()) write_file_atomically(options.out, csv(measured, made), FileKind::kTable, Over::kItsInput);
  if (!options.page.empty()) write_performance_page(options.page, measured, made);
  if (options.json) {
    print_json(measured);
  } else {
    print_table(measured);
  }
}

}  // namespace

void add_bench_command(cli::Command& app) {
  auto options = std::make_shared<Options>();
  cli::Command* command = app.add_command("bench", "Measure time and error of each part, compared with baselines");
  command->footer("Example:\n  typodont bench surface sound --out bench.csv");
  std::vector<std::string> names;
  for (const BenchPart& part : bench_parts()) names.emplace_back(part.name);
  command->add_option("name", options->names, "parts to measure; all when none is named")->check(cli::one_of(names));
  command->add_option("--out", options->out, "write the rows as CSV, with machine, compiler, flags and date")
      ->check(cli::writes({FileKind::kTable}, Over::kItsInput));
  command->add_option("--keep", options->keep,
                      "keep the rows that these CSVs, separated by commas, have of the other parts and tissues");
  command->add_flag("--merge", options->merge, "measure nothing: take all rows from the CSVs of --keep");
  command->add_option("--page", options->page, "write them as a page (.md) with plots beside it");
  command->add_option(
      "--tissues", options->tissues,
      "tissues that `models` measures, separated by commas: " + fmt::format("{}", fmt::join(compared_tissues(), ", ")));
  command->add_option(
      "--model", options->model,
      "contact model that `contact` measures instead of the default, " + haptics::known_contact_methods());
  command->add_flag("--quick", options->quick, "fewer repeats: fast, but not a measurement");
  command->add_flag("--json", options->json, "print the rows as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
