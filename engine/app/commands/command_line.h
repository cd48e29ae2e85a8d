// The command line: commands, their options, and what an option's value must be. The words are read by CLI11, which
// only command_line.cpp includes: it costs 8 s in every file that does.
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

/// What the value of an option must be; whatever else is refused with a message that says so.
class Check {
 public:
  explicit Check(std::shared_ptr<const CLI::Validator> validator) : validator_(std::move(validator)) {}

 private:
  friend class Option;
  std::shared_ptr<const CLI::Validator> validator_;
};
/// A finite number from low to high, both included.
Check range(double low, double high);
Check range(int low, int high);
/// Above 0, up to `most`.
Check more_than_zero(double most = 1e9);
/// A whole number from 0 on: a monitor, a channel.
Check from_zero();
Check one_of(std::vector<std::string> words);
Check existing_file();
/// A name that the command may write a file of one of these kinds to: its ending is one of theirs (a device or a FIFO
/// may be called anything), its folder can be written to, and nothing there has to stay (PartialFile).
Check writes(std::initializer_list<FileKind> kinds, Over over = Over::kNoInput);

class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option* check(const Check& check);
  Option* required();
  /// The help shows the value that the variable has now.
  Option* show_default();
  /// So many words after the option's name.
  Option* expected(int count);
  /// At most one word; without one the value is `usual`. `word`: what the help calls it.
  Option* optional_word(const std::string& usual, const std::string& word);

 private:
  CLI::Option* option_;
};

/// A command with its options and commands of its own; the root is the program itself. What it returns pointers to
/// lives as long as the root. Variables are written by the root's run() and must outlive that.
class Command {
 public:
  Command(const std::string& name, const std::string& about);
  ~Command();
  Command(Command&&) noexcept;

  Command* add_command(const std::string& name, const std::string& about);
  /// `name`: "--out", or the bare name of a word by its place. T: a string, number or path, an optional or a vector of
  /// them, as listed in command_line.cpp.
  template <class T>
  Option* add_option(const std::string& name, T& value, const std::string& about = "");
  Option* add_flag(const std::string& name, bool& value, const std::string& about = "");
  /// Shown below the help.
  void footer(const std::string& text);
  void version(const std::string& text);
  /// How many of its commands must be named, and may be.
  void expect_commands(int least, int most);
  /// The work, once all options are read. It may throw.
  void callback(std::function<void()> work);
  /// Throws Error where one of `options` was given although `needed` (in words, "--view section") was not.
  void refuse_without(std::initializer_list<const char*> options, bool given, const std::string& needed) const;
  /// Whether one of its commands was named.
  bool named_command() const;
  std::string help() const;

  /// The root's: reads the words and runs the command that they name. Nothing where that was done; the exit status
  /// where it ended with the words: 0 after --help and --version, 2 where they are not understood. Throws what the work
  /// throws.
  std::optional<int> run(int argc, char** argv);

 private:
  struct Impl;
  explicit Command(CLI::App* app);
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::cli
