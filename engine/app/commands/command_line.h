// The command line: commands, options, and checks of option values. CLI11 parses the command line. Only
// command_line.cpp includes CLI11, because its header adds 8 s to the compile time of a file.
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

/// A check of an option's value. If the value fails the check, a message states which values are expected.
class Check {
 public:
  explicit Check(std::shared_ptr<const CLI::Validator> validator) : validator_(std::move(validator)) {}

 private:
  friend class Option;
  std::shared_ptr<const CLI::Validator> validator_;
};
/// Accepts a finite number from low to high, inclusive.
Check range(double low, double high);
Check range(int low, int high);
/// Accepts a number x with 0 < x <= `most`.
Check more_than_zero(double most = 1e9);
/// Accepts a whole number that is 0 or larger, for example the number of a monitor or channel.
Check from_zero();
Check one_of(std::vector<std::string> words);
Check existing_file();
/// Accepts the name of a file that the command may write. The extension must belong to one of `kinds` (a device or FIFO
/// may have any name), and the folder must be writable. `over` says if an existing file may be overwritten
/// (PartialFile).
Check writes(std::initializer_list<FileKind> kinds, Over over = Over::kNoInput);
/// Accepts the name of a folder for results. The name must not be that of an existing file, nor end like the name of a
/// file (for example ".png").
Check writes_folder();

class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option* check(const Check& check);
  Option* required();
  /// Makes the help show the variable's present value as the default.
  Option* show_default();
  /// The option takes `count` values.
  Option* expected(int count);
  /// Lets the user write the option without a value; its value is then `usual`. `word`: word that stands for the value
  /// in the help.
  Option* optional_word(const std::string& usual, const std::string& word);

 private:
  CLI::Option* option_;
};

/// A command with its options and subcommands. The root command is the program itself. Pointers that a member function
/// returns are valid as long as the root exists. run() of the root stores the option values in variables of the caller,
/// so these variables must exist longer than the root.
class Command {
 public:
  Command(const std::string& name, const std::string& about);
  ~Command();
  Command(Command&&) noexcept;

  Command* add_command(const std::string& name, const std::string& about);
  /// Adds an option. `name`: "--out" for an option, or a name without "--" for a positional argument. T: a string, a
  /// number, a path, or an optional or vector of these types, as listed in command_line.cpp.
  template <class T>
  Option* add_option(const std::string& name, T& value, const std::string& about = "");
  Option* add_flag(const std::string& name, bool& value, const std::string& about = "");
  /// Sets a text that the help shows at its end.
  void footer(const std::string& text);
  void version(const std::string& text);
  /// Sets the smallest and the largest number of subcommands that may be given.
  void expect_commands(int least, int most);
  /// Sets the function that executes the command. It is called when all options have been read, and may throw.
  void callback(std::function<void()> work);
  /// The `options` have an effect only together with another option. Throws Error if one of them is on the command line
  /// and the other option is missing. `given`: true if the other option is on the command line. `needed`: text of the
  /// other option, such as "--view section".
  void refuse_without(std::initializer_list<const char*> options, bool given, const std::string& needed) const;
  /// Returns true if the command line contains a subcommand of this command.
  bool named_command() const;
  std::string help() const;

  /// Parses the command line and runs the command that it names. Call it only on the root. Returns an empty optional
  /// after a command ran, otherwise the exit status: 0 after --help and --version, 2 if the command line is invalid.
  /// Throws the exceptions of the command's work.
  std::optional<int> run(int argc, char** argv);

 private:
  struct Impl;
  explicit Command(CLI::App* app);
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::cli
