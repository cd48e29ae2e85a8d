#include "engine/base/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/partial_file.h"

namespace typodont {

using Value = nlohmann::json;

struct Json::Document {
  std::filesystem::path file;
  std::string text;  // as it was parsed; empty: lines are not named
  Value root;
};

namespace {

constexpr std::size_t kDeepest = 200;  // levels; the destructor of a deeper document overflows the stack

const Value& as_value(const void* value) {
  return *static_cast<const Value*>(value);
}

std::string shorten(std::string text) {
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

std::size_t line_of(std::string_view text, std::size_t byte) {
  return 1 + static_cast<std::size_t>(std::count(text.begin(), text.begin() + std::min(byte, text.size()), '\n'));
}

/// In characters, from 1.
std::size_t column_of(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte);
  const std::string_view line = before.substr(before.rfind('\n') + 1);  // npos + 1 is 0
  return 1 + static_cast<std::size_t>(std::count_if(
                 line.begin(), line.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

/// Characters of a text, counted as they are read.
struct CountedText {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;
  const char* at;
  std::size_t* count;
  reference operator*() const { return *at; }
  CountedText& operator++() {
    ++at, ++*count;
    return *this;
  }
  CountedText operator++(int) {
    CountedText old = *this;
    ++*this;
    return old;
  }
  bool operator==(const CountedText& other) const { return at == other.at; }
};

/// Goes through a text value by value and knows where it is: finds what nlohmann's own parser accepts or tells without
/// its place (equal keys, depth, numbers beyond a double), and the line of a value.
class Walk final : public nlohmann::json_sax<Value> {
 public:
  /// `wanted`: the path of a value to stop at; null: go through all.
  explicit Walk(std::string_view text, const std::string* wanted = nullptr) : text_(text), wanted_(wanted) {
    Value::sax_parse(CountedText{text.data(), &read_}, CountedText{text.data() + text.size(), &read_}, this);
  }
  /// Where what is wrong is, and what: empty where all is right.
  std::string where, found, expected;
  /// Of the wanted value; 0: there is none.
  std::size_t line = 0;

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool start_object(std::size_t) override { return value() && open(true); }
  bool start_array(std::size_t) override { return value() && open(false); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    Level& level = levels_.back();
    level.key = name;
    if (level.keys.insert(name).second) return true;
    return wrong("the key twice", "each key once");
  }
  bool parse_error(std::size_t byte, const std::string& token, const nlohmann::detail::exception& e) override {
    constexpr int kOutOfRange = 406;
    if (e.id == kOutOfRange) {
      begin_value();
      return wrong(shorten(token), "a number of at most 1.8e308");
    }
    const std::size_t last = byte > 0 ? byte - 1 : 0;
    where = fmt::format("line {}, column {}", line_of(text_, last), column_of(text_, last));
    found = "text that is not JSON", expected = "valid JSON";
    return false;
  }

 private:
  struct Level {
    bool object;
    std::string key;
    std::size_t index = 0;       // of the next value in an array
    std::set<std::string> keys;  // of an object, so far
  };

  std::string path(bool short_keys) const {
    std::string text;
    for (const Level& level : levels_) {
      if (!level.object) {
        text += fmt::format("[{}]", level.index - 1);
      } else {
        text += fmt::format("{}{}", text.empty() ? "" : ".", short_keys ? shorten(level.key) : level.key);
      }
    }
    return text;
  }
  /// The parser has read one character beyond a number at most, and none beyond any other value.
  std::size_t line_here() const { return line_of(text_, read_ > 0 ? read_ - 1 : 0); }
  bool wrong(std::string what, std::string instead) {
    where = fmt::format("line {}, \"{}\"", line_here(), path(true));
    found = std::move(what), expected = std::move(instead);
    return false;
  }
  void begin_value() {
    if (!levels_.empty() && !levels_.back().object) ++levels_.back().index;
  }
  bool value() {
    begin_value();
    if (!wanted_ || path(false) != *wanted_) return true;
    line = line_here();
    return false;
  }
  bool open(bool object) {
    levels_.push_back({object, {}, 0, {}});
    if (levels_.size() <= kDeepest) return true;
    where = fmt::format("line {}", line_here());
    found = fmt::format("more than {} nested levels", kDeepest), expected = "a flat document";
    return false;
  }
  bool close() {
    levels_.pop_back();
    return true;
  }

  std::string_view text_;
  const std::string* wanted_;
  std::size_t read_ = 0;
  std::vector<Level> levels_;
};

Value parse_strictly(std::string_view text, std::string_view name) {
  const Walk walk(text);
  if (!walk.where.empty()) throw Error(name, walk.where, walk.found, walk.expected);
  return Value::parse(text);
}

}  // namespace

Json::Json(std::shared_ptr<const Document> document, const void* value, std::string path)
    : document_(std::move(document)), value_(value), path_(std::move(path)) {}

Json Json::load(const std::filesystem::path& file) {
  return parse(read_input(file, InputKind::kJson), file.string());
}

Json Json::parse(std::string_view text, std::string_view name, Lines lines) {
  auto document = std::make_shared<Document>();
  document->file = std::string(name);
  document->root = parse_strictly(text, name);
  if (lines == Lines::kNamed) document->text = text;
  return Json(document, &document->root, "");
}

/// `line 7, "a.b[2]"`, as far as both are known.
std::string Json::place(std::string_view path) const {
  std::string where = path.empty() ? "" : fmt::format("\"{}\"", path);
  if (document_->text.empty()) return where;
  const std::size_t line = Walk(document_->text, &path_).line;
  if (line > 0 && !path.empty()) where = fmt::format("line {}, {}", line, where);
  return where;
}

bool Json::is_object() const {
  return as_value(value_).is_object();
}
bool Json::is_array() const {
  return as_value(value_).is_array();
}
bool Json::is_string() const {
  return as_value(value_).is_string();
}
bool Json::is_number() const {
  return as_value(value_).is_number();
}

bool Json::has(std::string_view key) const {
  return is_object() && as_value(value_).contains(std::string(key));
}

Json Json::operator[](std::string_view key) const {
  if (!is_object()) fail("an object");
  auto found = find(key);
  if (!found) {
    throw Error(document_->file.string(), place(path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key)),
                "nothing", "this key");
  }
  return *found;
}

std::optional<Json> Json::find(std::string_view key) const {
  const Value& v = as_value(value_);
  if (!v.is_object()) fail("an object");
  const auto it = v.find(std::string(key));
  if (it == v.end()) return std::nullopt;
  return Json(document_, &*it, path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key));
}

std::vector<Json> Json::items() const {
  const Value& v = as_value(value_);
  if (!v.is_array()) fail("an array");
  std::vector<Json> result;
  for (std::size_t i = 0; i < v.size(); ++i) result.push_back(Json(document_, &v[i], fmt::format("{}[{}]", path_, i)));
  return result;
}

std::vector<std::string> Json::keys() const {
  if (!is_object()) fail("an object");
  std::vector<std::string> result;
  for (const auto& [key, value] : as_value(value_).items()) result.push_back(key);
  return result;
}

void Json::allow_only(std::initializer_list<std::string_view> allowed) const {
  if (!is_object()) fail("an object");
  for (const std::string& key : keys()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    const std::string name = shorten(key);
    throw Error(document_->file.string(), find(key)->place(path_.empty() ? name : fmt::format("{}.{}", path_, name)),
                "an unknown key", fmt::format("one of {}", fmt::join(allowed, ", ")));
  }
}

double Json::number(double min, double max) const {
  const Value& v = as_value(value_);
  const double x = v.is_number() ? v.get<double>() : std::nan("");
  if (!std::isfinite(x)) fail("a number");
  if (x < min || x > max) {
    if (std::isinf(max)) fail(fmt::format("at least {}", min));
    if (std::isinf(min)) fail(fmt::format("at most {}", max));
    fail(fmt::format("{} to {}", min, max));
  }
  return x;
}

long long Json::integer(long long min, long long max) const {
  const Value& v = as_value(value_);
  if (!v.is_number_integer()) fail("an integer");
  if (v.is_number_unsigned() && v.get<unsigned long long>() > static_cast<unsigned long long>(max)) {
    fail(fmt::format("{} to {}", min, max));
  }
  const long long x = v.get<long long>();
  if (x < min || x > max) fail(fmt::format("{} to {}", min, max));
  return x;
}

bool Json::boolean() const {
  if (!as_value(value_).is_boolean()) fail("true or false");
  return as_value(value_).get<bool>();
}

std::string Json::string() const {
  if (!is_string()) fail("a string");
  return as_value(value_).get<std::string>();
}

std::vector<double> Json::numbers(std::size_t count) const {
  if (!is_array() || as_value(value_).size() != count) fail(fmt::format("an array of {} numbers", count));
  std::vector<double> result;
  for (const Json& item : items()) result.push_back(item.number());
  return result;
}

dvec3 Json::vec3() const {
  const auto v = numbers(3);
  return {v[0], v[1], v[2]};
}

double Json::number_or(std::string_view key, double fallback, double min, double max) const {
  const auto v = find(key);
  return v ? v->number(min, max) : fallback;
}

bool Json::boolean_or(std::string_view key, bool fallback) const {
  const auto v = find(key);
  return v ? v->boolean() : fallback;
}

std::string Json::string_or(std::string_view key, std::string_view fallback) const {
  const auto v = find(key);
  return v ? v->string() : std::string(fallback);
}

void Json::fail(std::string_view expected) const {
  fail(text(), expected);
}

void Json::fail(std::string_view found, std::string_view expected) const {
  throw Error(document_->file.string(), place(path_), shorten(std::string(found)), expected);
}

const std::filesystem::path& Json::file() const {
  return document_->file;
}

std::string Json::text() const {
  return as_value(value_).dump(-1, ' ', false, Value::error_handler_t::replace);
}

void write_file_atomically(const std::filesystem::path& file, std::string_view bytes, FileKind kind, Over over) {
  PartialFile partial(file, kind, over);
  errno = 0;
  std::ofstream out(partial.path(), std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw Error(file.string(), "", errno ? std::strerror(errno) : "a short write", "a writable place");
  partial.keep();
}

}  // namespace typodont
