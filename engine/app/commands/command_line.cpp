#include "engine/app/commands/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/stream_file.h"

namespace typodont::cli {

namespace {

Check check_of(const CLI::Validator& validator) {
  return Check(std::make_shared<const CLI::Validator>(validator));
}

constexpr std::size_t kLongest = 40;  // characters; longer arguments are shortened in messages

std::string shown(const std::string& text) {
  return text.size() > kLongest ? text.substr(0, kLongest - 3) + "..." : text;
}

/// Converts text to a number; NaN if the text is not a finite number.
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

/// Makes all options refuse "nan" and "inf", because a range check accepts "nan", and "inf" could cause endless work.
void take_finite_numbers_only(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) take_finite_numbers_only(*option);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) take_finite_numbers_only(*command);
}

}  // namespace

Check range(double low, double high) {
  return check_of(number_that(fmt::format("{:g} to {:g}", low, high),
                              [low, high](double value) { return value >= low && value <= high; }));
}
Check range(int low, int high) {
  return range(static_cast<double>(low), static_cast<double>(high));
}
Check more_than_zero(double most) {
  return check_of(number_that(fmt::format("more than 0, at most {:g}", most),
                              [most](double value) { return value > 0 && value <= most; }));
}
Check from_zero() {
  return check_of(number_that("a whole number from 0 on",
                              [](double value) { return value >= 0 && value < 1e9 && value == std::floor(value); }));
}
Check writes(std::initializer_list<FileKind> kinds, Over over) {
  return check_of(CLI::Validator(
      [kinds = std::vector<FileKind>(kinds), over](std::string& name) -> std::string {
        const std::filesystem::path file = name;
        FileKind kind = kind_of_name(file, kinds);
        if (kind == FileKind::kText && is_stream(file)) kind = kinds.front();
        if (kind == FileKind::kText) {
          std::vector<std::string_view> names;
          for (const FileKind known : kinds) names.push_back(name_of(known));
          return fmt::format("found \"{}\", expected the name of {}", shown(file.filename().string()),
                             fmt::join(names, " or "));
        }
        try {
          require_output(file, kind, over);
        } catch (const Error& e) {
          return e.what();
        }
        return {};
      },
      "", ""));
}

Check writes_folder() {
  return check_of(CLI::Validator(
      [](std::string& name) -> std::string {
        const std::filesystem::path folder = name;
        std::error_code none;
        if (std::filesystem::is_directory(folder, none)) return {};
        const auto found = [&](std::string_view what) {
          return fmt::format("found {}\"{}\", expected the name of a folder", what, shown(folder.filename().string()));
        };
        if (std::filesystem::exists(folder, none)) return found("the file ");
        if (kind_of_name(folder) != FileKind::kText) return found("");
        return {};
      },
      "", ""));
}

Check one_of(std::vector<std::string> words) {
  return check_of(CLI::IsMember(std::move(words)));
}
Check existing_file() {
  return check_of(CLI::ExistingFile);
}

Option* Option::check(const Check& check) {
  option_->check(*check.validator_);
  return this;
}
Option* Option::required() {
  option_->required();
  return this;
}
Option* Option::show_default() {
  option_->capture_default_str();
  return this;
}
Option* Option::expected(int count) {
  option_->expected(count);
  return this;
}
Option* Option::optional_word(const std::string& usual, const std::string& word) {
  option_->expected(0, 1)->default_str(usual)->type_name(word);
  return this;
}

struct Command::Impl {
  std::unique_ptr<CLI::App> root;  // only in the program's root command, which owns all commands
  CLI::App* app;
  std::deque<Option> options;
  std::deque<Command> commands;
};

Command::Command(const std::string& name, const std::string& about) : impl_(std::make_unique<Impl>()) {
  impl_->root = std::make_unique<CLI::App>(about, name);
  impl_->app = impl_->root.get();
}
Command::Command(CLI::App* app) : impl_(std::make_unique<Impl>()) {
  impl_->app = app;
}
Command::~Command() = default;
Command::Command(Command&&) noexcept = default;

Command* Command::add_command(const std::string& name, const std::string& about) {
  return &impl_->commands.emplace_back(Command(impl_->app->add_subcommand(name, about)));
}

template <class T>
Option* Command::add_option(const std::string& name, T& value, const std::string& about) {
  return &impl_->options.emplace_back(impl_->app->add_option(name, value, about));
}
template Option* Command::add_option(const std::string&, std::string&, const std::string&);
template Option* Command::add_option(const std::string&, std::filesystem::path&, const std::string&);
template Option* Command::add_option(const std::string&, double&, const std::string&);
template Option* Command::add_option(const std::string&, int&, const std::string&);
template Option* Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option* Command::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option* Command::add_option(const std::string&, std::optional<int>&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<double>&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<int>&, const std::string&);

Option* Command::add_flag(const std::string& name, bool& value, const std::string& about) {
  return &impl_->options.emplace_back(impl_->app->add_flag(name, value, about));
}
void Command::footer(const std::string& text) {
  impl_->app->footer(text);
}
void Command::version(const std::string& text) {
  impl_->app->set_version_flag("--version", text);
}
void Command::expect_commands(int least, int most) {
  impl_->app->require_subcommand(static_cast<std::size_t>(least), static_cast<std::size_t>(most));
}
void Command::callback(std::function<void()> work) {
  impl_->app->callback(std::move(work));
}
void Command::refuse_without(std::initializer_list<const char*> options, bool given, const std::string& needed) const {
  if (given) return;
  for (const char* option : options) {
    if (impl_->app->count(option) > 0) throw Error("", option, "it without " + needed, "both or none");
  }
}
bool Command::named_command() const {
  return !impl_->app->get_subcommands().empty();
}
std::string Command::help() const {
  return impl_->app->help();
}

std::optional<int> Command::run(int argc, char** argv) {
  take_finite_numbers_only(*impl_->app);
  try {
    impl_->app->parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::Success& e) {  // the command line contains --help or --version
    return impl_->app->exit(e);
  } catch (const CLI::ParseError& e) {
    impl_->app->exit(e);
    return 2;
  }
}

}  // namespace typodont::cli
