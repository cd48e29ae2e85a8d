// Reads JSON files. Errors name the file, the key, the value found and the value expected.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/partial_file.h"
#include "engine/base/pose.h"

namespace typodont {

class Keys;  // engine/base/keys.h

/// A JSON value with its file and path, which messages name. Cheap to copy. Not for real-time loops. Throws Error.
class Json {
 public:
  /// Whether messages name the line. kUnknown is for text that the program has built: there is no file to look in.
  enum class Lines { kNamed, kUnknown };

  /// Reads a file. Errors: duplicate keys, NaN, numbers beyond the range of double, text after the document.
  static Json load(const std::filesystem::path& file);
  /// Parses a text. `name` replaces the file in messages.
  static Json parse(std::string_view text, std::string_view name, Lines lines = Lines::kNamed);

  bool is_object() const;
  bool is_array() const;
  bool is_string() const;
  bool is_number() const;

  bool has(std::string_view key) const;
  Json operator[](std::string_view key) const;           // throws Error if the key is missing
  std::optional<Json> find(std::string_view key) const;  // no value if the key is missing
  std::vector<Json> items() const;                       // the elements of an array
  std::vector<std::string> keys() const;                 // the keys of an object
  /// Throws Error if the object has other keys than these.
  void allow_only(std::span<const std::string_view> keys) const;
  void allow_only(std::initializer_list<std::string_view> keys) const {
    allow_only(std::span(keys.begin(), keys.size()));
  }

  /// The value as a finite number from min to max. Throws Error otherwise.
  double number(double min = -std::numeric_limits<double>::infinity(),
                double max = std::numeric_limits<double>::infinity()) const;
  long long integer(long long min = std::numeric_limits<long long>::min(),
                    long long max = std::numeric_limits<long long>::max()) const;
  bool boolean() const;
  std::string string() const;
  dvec3 vec3() const;  // the vector [x, y, z]
  // The numbers of an array with exactly `count` elements.
  std::vector<double> numbers(std::size_t count) const;

  double number_or(std::string_view key, double fallback, double min = -std::numeric_limits<double>::infinity(),
                   double max = std::numeric_limits<double>::infinity()) const;
  bool boolean_or(std::string_view key, bool fallback) const;
  std::string string_or(std::string_view key, std::string_view fallback) const;

  /// Throws Error with the message: FILE: line 7, "a.b[2]": found …, expected ….
  [[noreturn]] void fail(std::string_view expected) const;
  [[noreturn]] void fail(std::string_view found, std::string_view expected) const;
  const std::filesystem::path& file() const;
  std::string text() const;  // returns this value as compact JSON

 private:
  struct Document;
  std::string place(std::string_view path) const;
  Json(std::shared_ptr<const Document> document, const void* value, std::string path);
  std::shared_ptr<const Document> document_;
  const void* value_;
  std::string path_;
};

/// Writes a file completely or not at all, as PartialFile does. Throws Error.
void write_file_atomically(const std::filesystem::path& file, std::string_view bytes, FileKind kind = FileKind::kText,
                           Over over = Over::kNoInput);

}  // namespace typodont
