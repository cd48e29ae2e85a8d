#include "engine/app/commands/option_checks.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/stream_file.h"

namespace typodont {

namespace {

constexpr std::size_t kLongest = 40;  // characters of an argument that a message shows

std::string shown(const std::string& text) {
  return text.size() > kLongest ? text.substr(0, kLongest - 3) + "..." : text;
}

/// NaN where the text is no finite number.
double number_of(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool whole = !text.empty() && end == text.c_str() + text.size();
  return whole && std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
}

CLI::Validator number_that(std::string expected, std::function<bool(double)> holds) {
  const std::string words = expected;
  return CLI::Validator(
      [expected = std::move(expected), holds = std::move(holds)](std::string& text) -> std::string {
        const double value = number_of(text);
        if (std::isfinite(value) && holds(value)) return {};
        return fmt::format("found {}, expected {}", shown(text), expected);
      },
      words, "");
}

void take_finite_numbers_only(CLI::Option& option) {
  if (option.get_type_name().find("FLOAT") == std::string::npos) return;
  option.check(CLI::Validator(
      [](std::string& text) -> std::string {
        if (std::isfinite(number_of(text))) return {};
        return fmt::format("found {}, expected a finite number", shown(text));
      },
      "", ""));
}

}  // namespace

CLI::Validator number_in(double least, double most) {
  return number_that(fmt::format("{:g} to {:g}", least, most),
                     [least, most](double value) { return value >= least && value <= most; });
}

CLI::Validator more_than_zero(double most) {
  return number_that(fmt::format("more than 0, at most {:g}", most),
                     [most](double value) { return value > 0 && value <= most; });
}

CLI::Validator from_zero() {
  return number_that("a whole number from 0 on",
                     [](double value) { return value >= 0 && value < 1e9 && value == std::floor(value); });
}

CLI::Validator writes(std::initializer_list<FileKind> kinds, Over over) {
  return CLI::Validator(
      [kinds = std::vector<FileKind>(kinds), over](std::string& name) -> std::string {
        const std::filesystem::path file = name;
        FileKind kind = kind_of_name(file, kinds);
        if (kind == FileKind::kText && is_stream(file)) kind = kinds.front();
        if (kind == FileKind::kText) {
          std::vector<std::string_view> names;
          for (const FileKind known : kinds) names.push_back(name_of(known));
          return fmt::format("found \"{}\", expected the name of {}", shown(name), fmt::join(names, " or "));
        }
        try {
          require_output(file, kind, over);
        } catch (const Error& e) {
          return e.what();
        }
        return {};
      },
      "", "");
}

void take_finite_numbers_only(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) take_finite_numbers_only(*option);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) take_finite_numbers_only(*command);
}

void refuse_without(const CLI::App& command, std::initializer_list<const char*> options, bool given,
                    const std::string& needed) {
  if (given) return;
  for (const char* option : options) {
    if (command.count(option) > 0) throw Error("", option, "it without " + needed, "both or none");
  }
}

}  // namespace typodont
