// Commands, their options, and checks of the values. Only command_line.cpp includes CLI11, whose header takes 8 s to
// compile.
#pragma once

#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/partial_file.h"

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace typodont::cli {

/// Checks an option's value. The message states what is expected.
class Check {
 public:
  explicit Check(std::shared_ptr<const CLI::Validator> validator) : validator_(std::move(validator)) {}

 private:
  friend class Option;
  std::shared_ptr<const CLI::Validator> validator_;
};
/// Accepts a finite number from `low` to `high`, both included.
Check range(double low, double high);
Check range(int low, int high);
/// Accepts a number x with 0 < x <= `most`.
Check more_than_zero(double most = 1e9);
/// Accepts a whole number from 0 up, for example a monitor's number.
Check from_zero();
Check one_of(std::vector<std::string> words);
Check existing_file();
/// A file that the command may write, in a writable folder. Its extension belongs to one of `kinds`; devices and FIFOs
/// may have any name. `over`: which files may be overwritten.
Check writes(std::initializer_list<FileKind> kinds, Over over = Over::kNoInput);
/// Accepts a folder for results: not the name of an existing file, and no name with a file's extension.
Check writes_folder();

class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option* check(const Check& check);
  Option* required();
  /// Makes the help show the variable's current value as the default (Command::add_setting).
  Option* show_default();
  /// Makes the option take `count` values.
  Option* expected(int count);
  /// Allows the option without a value; its value is then `usual`. `word`: name of the value in the help.
  Option* optional_word(const std::string& usual, const std::string& word);

 private:
  CLI::Option* option_;
};

/// A command with options and subcommands; the root command is the program. Returned pointers are valid as long as the
/// root. run() writes values into the caller's variables, which must outlive the root.
class Command {
 public:
  Command(const std::string& name, const std::string& about);
  ~Command();
  Command(Command&&) noexcept;

  Command* add_command(const std::string& name, const std::string& about);
  /// Adds an option. `name`: "--out", or without "--" for a positional argument. T: string, number, path, or optional
  /// or vector of these (command_line.cpp). `about`: text of the help, the option's only description.
  template <class T>
  Option* add_option(const std::string& name, T& value, const std::string& about);
  template <class T>
  Option* add_option(const std::string& name, T& value, const std::string& about, const Check& check) {
    return add_option(name, value, about)->check(check);
  }
  /// Adds an option whose help shows the variable's current value as the default.
  template <class T, class... Checks>
  Option* add_setting(const std::string& name, T& value, const std::string& about, const Checks&... checks) {
    return add_option(name, value, about, checks...)->show_default();
  }
  Option* add_flag(const std::string& name, bool& value, const std::string& about);
  /// Adds text at the end of the help.
  void footer(const std::string& text);
  void version(const std::string& text);
  /// Sets the smallest and largest number of subcommands.
  void expect_commands(int least, int most);
  /// `work` is called after all options are read. May throw.
  void callback(std::function<void()> work);
  /// Throws Error if one of `options` is given without the option that it needs. `given`: the needed option is given;
  /// `needed`: its text, for example "--view section".
  void refuse_without(std::initializer_list<const char*> options, bool given, const std::string& needed) const;
  /// True if the command line names a subcommand of this command.
  bool named_command() const;
  std::string help() const;

  /// Runs the command line; for the root only. Empty if a command ran; otherwise the exit status: 0 after --help and
  /// --version, 2 for an invalid command line. Throws what the command throws.
  std::optional<int> run(int argc, char** argv);

 private:
  struct Impl;
  explicit Command(CLI::App* app);
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::cli
