#include "engine/base/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <utility>
#include <variant>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/partial_file.h"
#include "engine/base/utf8.h"

namespace typodont {

namespace {

std::string shorten(std::string text) {
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

struct Node;
struct Member;
using Array = std::vector<Node>;
using Object = std::vector<Member>;  // sorted by key; no key occurs twice

/// A parsed JSON value (RFC 8259). Whole numbers that fit into 64 bits are integers.
struct Node {
  std::variant<std::nullptr_t, bool, std::int64_t, std::uint64_t, double, std::string, Array, Object> value;
  std::size_t line = 0;  // line on which the value begins, from 1

  template <class T>
  const T* as() const {
    return std::get_if<T>(&value);
  }
  bool is_integer() const { return as<std::int64_t>() || as<std::uint64_t>(); }
};
struct Member {
  std::string key;
  Node value;
};

/// Reads a text for the parser, and stores in `read` how far it was read.
struct TextIterator {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  const char* at;
  const char** read;
  const char& operator*() const { return *at; }
  TextIterator& operator++() {
    *read = ++at;
    return *this;
  }
  bool operator==(const TextIterator& other) const { return at == other.at; }
  bool operator!=(const TextIterator& other) const { return at != other.at; }
};

/// Builds nodes from the parser's events. Throws Error.
class Reader final : public nlohmann::json_sax<nlohmann::json> {
 public:
  Reader(std::string_view text, std::string_view name) : text_(text), name_(name) {}

  Node document() {
    nlohmann::json::sax_parse(TextIterator{text_.data(), &read_}, TextIterator{text_.data() + text_.size(), &read_},
                              this);
    return std::move(root_);
  }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(std::int64_t value) override { return add(value); }
  bool number_unsigned(std::uint64_t value) override { return add(value); }
  bool number_float(double value, const std::string&) override { return add(value); }
  bool string(std::string& value) override { return add(std::move(value)); }
  bool binary(nlohmann::json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return enter(Object{}); }
  bool start_array(std::size_t) override { return enter(Array{}); }
  bool end_array() override { return leave(); }

  bool key(std::string& key) override {
    key_ = std::move(key);
    if (!open_.back().keys.insert(key_).second)
      throw Error(name_, fmt::format("line {}, \"{}\"", line(), path_of_next()), "the key twice", "each key once");
    return true;
  }
  bool end_object() override {
    Object& members = std::get<Object>(open_.back().node->value);
    std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) { return a.key < b.key; });
    return leave();
  }
  bool parse_error(std::size_t position, const std::string& token, const nlohmann::json::exception& e) override {
    constexpr int kOutOfRange = 406;  // the parser's code for a number out of range
    if (e.id == kOutOfRange) {
      throw Error(name_, fmt::format("line {}, \"{}\"", line(), path_of_next()), shorten(token),
                  "a number of at most 1.8e308");
    }
    const std::string_view before = text_.substr(0, position - 1);
    // On the first line, rfind() gives npos, and npos + 1 is 0.
    const std::size_t column = 1 + count_characters(before.substr(before.rfind('\n') + 1));
    throw Error(name_, fmt::format("line {}, column {}", 1 + std::count(before.begin(), before.end(), '\n'), column),
                "text that is not JSON", "valid JSON");
  }

 private:
  struct Open {
    Node* node;
    std::set<std::string> keys;
    std::string path;  // path of `node` in the document, for messages; long keys are shortened
  };

  /// Line of the last value, from 1. Ignores the last character that was read: it may be a line end behind a number.
  std::size_t line() {
    const char* end = read_ - 1;
    line_ += static_cast<std::size_t>(std::count(counted_, end, '\n'));
    counted_ = end;
    return line_;
  }
  std::string path_of_next() const {
    if (open_.empty()) return "";
    const Open& in = open_.back();
    if (const Array* items = in.node->as<Array>()) return fmt::format("{}[{}]", in.path, items->size());
    return fmt::format("{}{}{}", in.path, in.path.empty() ? "" : ".", shorten(key_));
  }
  template <class T>
  Node* put(T&& value) {
    Node* node = &root_;
    if (!open_.empty()) {
      Node& in = *open_.back().node;
      if (Array* items = std::get_if<Array>(&in.value))
        node = &items->emplace_back();
      else
        node = &std::get<Object>(in.value).emplace_back(Member{std::move(key_), {}}).value;
    }
    node->value = std::forward<T>(value);
    node->line = line();
    return node;
  }
  template <class T>
  bool add(T&& value) {
    put(std::forward<T>(value));
    return true;
  }
  template <class T>
  bool enter(T&& empty) {
    constexpr std::size_t kDeepest = 200;  // largest nesting depth; a deeper value's destructor can overflow the stack
    if (open_.size() == kDeepest) {
      throw Error(name_, fmt::format("line {}", line()), fmt::format("more than {} nested levels", kDeepest),
                  "a flat document");
    }
    std::string path = path_of_next();
    open_.push_back({put(std::forward<T>(empty)), {}, std::move(path)});
    return true;
  }
  bool leave() {
    open_.pop_back();
    return true;
  }

  std::string_view text_, name_;
  const char *read_ = text_.data(), *counted_ = text_.data();
  std::size_t line_ = 1;
  Node root_;
  std::string key_;
  std::vector<Open> open_;  // arrays and objects that are not closed yet; their nodes do not move
};

nlohmann::ordered_json json_of(const Node& node) {
  if (const auto* array = node.as<Array>()) {
    auto items = nlohmann::ordered_json::array();
    for (const Node& item : *array) items.push_back(json_of(item));
    return items;
  }
  if (const auto* object = node.as<Object>()) {
    auto members = nlohmann::ordered_json::object();
    for (const Member& member : *object) members[member.key] = json_of(member.value);
    return members;
  }
  return std::visit(
      [](const auto& value) -> nlohmann::ordered_json {
        if constexpr (std::is_constructible_v<nlohmann::ordered_json, decltype(value)>) return value;
        return nullptr;
      },
      node.value);
}

const Node& as_node(const void* value) {
  return *static_cast<const Node*>(value);
}

}  // namespace

struct Json::Document {
  std::filesystem::path file;
  bool lines_named = true;
  Node root;
};

Json::Json(std::shared_ptr<const Document> document, const void* value, std::string path)
    : document_(std::move(document)), value_(value), path_(std::move(path)) {}

Json Json::load(const std::filesystem::path& file) {
  return parse(read_input(file, InputKind::kJson), file.string());
}

Json Json::parse(std::string_view text, std::string_view name, Lines lines) {
  auto document = std::make_shared<Document>();
  document->file = std::string(name);
  document->lines_named = lines == Lines::kNamed;
  document->root = Reader(text, name).document();
  return Json(document, &document->root, "");
}

/// Place of a value for messages, for example `line 7, "a.b[2]"`. Unknown parts are left out.
std::string Json::place(std::string_view path) const {
  if (path.empty()) return "";
  if (!document_->lines_named) return fmt::format("\"{}\"", path);
  return fmt::format("line {}, \"{}\"", as_node(value_).line, path);
}

bool Json::is_object() const {
  return as_node(value_).as<Object>();
}
bool Json::is_array() const {
  return as_node(value_).as<Array>();
}
bool Json::is_string() const {
  return as_node(value_).as<std::string>();
}
bool Json::is_number() const {
  return as_node(value_).is_integer() || as_node(value_).as<double>();
}

bool Json::has(std::string_view key) const {
  return is_object() && find(key);
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
  const Object* members = as_node(value_).as<Object>();
  if (!members) fail("an object");
  const auto it = std::lower_bound(members->begin(), members->end(), key,
                                   [](const Member& member, std::string_view wanted) { return member.key < wanted; });
  if (it == members->end() || it->key != key) return std::nullopt;
  return Json(document_, &it->value, fmt::format("{}{}{}", path_, path_.empty() ? "" : ".", shorten(std::string(key))));
}

std::vector<Json> Json::items() const {
  const Array* items = as_node(value_).as<Array>();
  if (!items) fail("an array");
  std::vector<Json> result;
  for (std::size_t i = 0; i < items->size(); ++i) {
    result.push_back(Json(document_, &(*items)[i], fmt::format("{}[{}]", path_, i)));
  }
  return result;
}

std::vector<std::string> Json::keys() const {
  const Object* members = as_node(value_).as<Object>();
  if (!members) fail("an object");
  std::vector<std::string> result;
  for (const Member& member : *members) result.push_back(member.key);
  return result;
}

namespace {

/// Smallest number of letters to insert, delete, replace or exchange with the next one (optimal string alignment).
std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, last, row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::exchange(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

}  // namespace

void Json::allow_only(std::span<const std::string_view> allowed) const {
  if (!is_object()) fail("an object");
  for (const std::string& key : keys()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    std::string found = "an unknown key";
    constexpr std::size_t kLongest = 64;
    const auto edits = [&](std::string_view known) { return edits_between(key.substr(0, kLongest), known); };
    const auto nearest = std::ranges::min_element(allowed, {}, edits);
    if (nearest != allowed.end() && 3 * edits(*nearest) <= nearest->size())
      found += fmt::format(" (is \"{}\" meant?)", *nearest);
    find(key)->fail(found, fmt::format("one of {}", fmt::join(allowed, ", ")));
  }
}

double Json::number(double min, double max) const {
  const Node& node = as_node(value_);
  double x = std::nan("");
  if (const auto* i = node.as<std::int64_t>()) x = static_cast<double>(*i);
  if (const auto* u = node.as<std::uint64_t>()) x = static_cast<double>(*u);
  if (const auto* d = node.as<double>()) x = *d;
  if (!std::isfinite(x)) fail("a number");
  if (x < min || x > max) {
    if (std::isinf(max)) fail(fmt::format("at least {}", min));
    if (std::isinf(min)) fail(fmt::format("at most {}", max));
    fail(fmt::format("{} to {}", min, max));
  }
  return x;
}

long long Json::integer(long long min, long long max) const {
  const Node& node = as_node(value_);
  if (!node.is_integer()) fail("an integer");
  const auto* u = node.as<std::uint64_t>();
  const long long x = u ? static_cast<long long>(*u) : *node.as<std::int64_t>();
  if ((u && !std::in_range<long long>(*u)) || x < min || x > max) fail(fmt::format("{} to {}", min, max));
  return x;
}

bool Json::boolean() const {
  const bool* value = as_node(value_).as<bool>();
  if (!value) fail("true or false");
  return *value;
}

std::string Json::string() const {
  const std::string* value = as_node(value_).as<std::string>();
  if (!value) fail("a string");
  return *value;
}

std::vector<double> Json::numbers(std::size_t count) const {
  const Array* array = as_node(value_).as<Array>();
  if (!array || array->size() != count) fail(fmt::format("an array of {} numbers", count));
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
  return json_of(as_node(value_)).dump();
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
