#include "engine/app/commands/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <utility>

namespace typodont::cli {

namespace {

Check check_of(const CLI::Validator& validator) {
  return Check(std::make_shared<const CLI::Validator>(validator));
}

}  // namespace

Check range(double low, double high) {
  return check_of(CLI::Range(low, high));
}
Check range(int low, int high) {
  return check_of(CLI::Range(low, high));
}
Check positive() {
  return check_of(CLI::PositiveNumber);
}
Check not_negative() {
  return check_of(CLI::NonNegativeNumber);
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
  std::unique_ptr<CLI::App> root;  // of the program itself; other commands belong to it
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
bool Command::named_command() const {
  return !impl_->app->get_subcommands().empty();
}
std::string Command::help() const {
  return impl_->app->help();
}

std::optional<int> Command::run(int argc, char** argv) {
  try {
    impl_->app->parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::Success& e) {  // --help, --version
    return impl_->app->exit(e);
  } catch (const CLI::ParseError& e) {
    impl_->app->exit(e);
    return 2;
  }
}

}  // namespace typodont::cli
