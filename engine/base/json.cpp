#include "engine/base/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
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

/// RFC 8259. Whole numbers of 64 bits are integers.
struct Node {
  std::variant<std::nullptr_t, bool, std::int64_t, std::uint64_t, double, std::string, Array, Object> value;
  std::size_t line = 0;  // where it begins, from 1

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

/// Strictly RFC 8259. Its own parser, so that the haptic core needs no library.
class Reader {
 public:
  Reader(std::string_view text, std::string_view name) : text_(text), name_(name) {}

  Node document() {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;  // skips a byte order mark
    Node root = value();
    skip_space();
    if (at_ < text_.size()) fail();
    return root;
  }

 private:
  // of nesting; deeper, the destructor would overflow the stack
  static constexpr int kDeepest = 200;

  /// In characters, from 1.
  std::size_t column() const {
    const std::string_view before = text_.substr(0, at_);
    // On the first line, rfind() gives npos, and npos + 1 is 0.
    const std::string_view line = before.substr(before.rfind('\n') + 1);
    return 1 + count_characters(line);
  }
  [[noreturn]] void fail() const {
    throw Error(name_, fmt::format("line {}, column {}", line_, column()), "text that is not JSON", "valid JSON");
  }
  /// About the value or key at hand.
  [[noreturn]] void fail(std::string_view found, std::string_view expected) const {
    throw Error(name_, fmt::format("line {}, \"{}\"", line_, path_), found, expected);
  }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool take(std::string_view word) {
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }
  void expect(std::string_view word) {
    for (const char c : word) {
      if (peek() != c) fail();
      ++at_;
    }
  }
  void skip_space() {
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '\n') ++line_;
      if (c != ' ' && c != '\t' && c != '\n' && c != '\r') return;
    }
  }

  Node value() {
    skip_space();
    const std::size_t line = line_;
    Node node;
    switch (peek()) {
      case '{':
        node.value = object();
        break;
      case '[':
        node.value = array();
        break;
      case '"':
        node.value = string();
        break;
      case 't':
        expect("true");
        node.value = true;
        break;
      case 'f':
        expect("false");
        node.value = false;
        break;
      case 'n':
        expect("null");
        break;
      default:
        number(node);
    }
    node.line = line;
    return node;
  }

  void enter() {
    ++at_;
    if (++depth_ > kDeepest) {
      throw Error(name_, fmt::format("line {}", line_), fmt::format("more than {} nested levels", kDeepest),
                  "a flat document");
    }
    skip_space();
  }

  Array array() {
    Array items;
    enter();
    const std::size_t path = path_.size();
    if (!take("]")) {
      do {
        path_ += fmt::format("[{}]", items.size());
        items.push_back(value());
        path_.resize(path);
        skip_space();
      } while (take(","));
      expect("]");
    }
    --depth_;
    return items;
  }

  Object object() {
    Object members;
    std::set<std::string> keys;
    enter();
    const std::size_t path = path_.size();
    if (!take("}")) {
      do {
        skip_space();
        if (peek() != '"') fail();
        std::string key = string();
        path_ += fmt::format("{}{}", path > 0 ? "." : "", shorten(key));
        if (!keys.insert(key).second) fail("the key twice", "each key once");
        skip_space();
        expect(":");
        members.push_back({std::move(key), value()});
        path_.resize(path);
        skip_space();
      } while (take(","));
      expect("}");
    }
    --depth_;
    std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) { return a.key < b.key; });
    return members;
  }

  void number(Node& node) {
    const std::size_t begin = at_;
    const auto digits = [&] {
      if (peek() < '0' || peek() > '9') fail();
      while (peek() >= '0' && peek() <= '9') ++at_;
    };
    const bool negative = take("-");
    if (!take("0")) digits();
    bool whole = true;
    if (take(".")) whole = false, digits();
    if (peek() == 'e' || peek() == 'E') {
      whole = false, ++at_;
      if (peek() == '+' || peek() == '-') ++at_;
      digits();
    }
    const char *first = text_.data() + begin, *last = text_.data() + at_;
    if (whole) {  // over 64 bits: a double, below
      std::int64_t s = 0;
      std::uint64_t u = 0;
      if (negative && std::from_chars(first, last, s).ec == std::errc()) {
        node.value = s;
        return;
      }
      if (!negative && std::from_chars(first, last, u).ec == std::errc()) {
        node.value = u;
        return;
      }
    }
    double d = 0;
    if (std::from_chars(first, last, d).ec != std::errc()) {  // outside a double's range
      d = std::strtod(std::string(first, last).c_str(), nullptr);
      if (!std::isfinite(d)) fail(shorten(std::string(first, last)), "a number of at most 1.8e308");
    }
    node.value = d;
  }

  unsigned four_hex_digits() {
    unsigned code = 0;
    const auto hex = text_.substr(at_, 4);
    if (hex.size() < 4 || std::from_chars(hex.data(), hex.data() + 4, code, 16).ptr != hex.data() + 4) fail();
    at_ += 4;
    return code;
  }

  void append_utf8(std::string& to, unsigned code) {
    const auto byte = [&](unsigned bits) { to.push_back(static_cast<char>(bits)); };
    if (code < 0x80) return byte(code);
    if (code < 0x800) {
      byte(0xC0 | code >> 6);
    } else {
      if (code < 0x10000) {
        byte(0xE0 | code >> 12);
      } else {
        byte(0xF0 | code >> 18), byte(0x80 | (code >> 12 & 0x3F));
      }
      byte(0x80 | (code >> 6 & 0x3F));
    }
    byte(0x80 | (code & 0x3F));
  }

  void escape(std::string& to) {
    constexpr std::string_view kLetters = "\"\\/bfnrt", kMeant = "\"\\/\b\f\n\r\t";
    const char letter = peek();
    ++at_;
    if (letter == 'u') {
      unsigned code = four_hex_digits();
      if (code >= 0xDC00 && code < 0xE000) fail();
      if (code >= 0xD800 && code < 0xDC00) {  // first half of a surrogate pair
        expect("\\u");
        const unsigned second = four_hex_digits();
        if (second < 0xDC00 || second >= 0xE000) fail();
        code = 0x10000 + ((code - 0xD800) << 10) + (second - 0xDC00);
      }
      return append_utf8(to, code);
    }
    const std::size_t which = kLetters.find(letter);
    if (letter == '\0' || which == std::string_view::npos) fail();
    to.push_back(kMeant[which]);
  }

  /// Shortest encoding only, and no surrogate.
  void copy_utf8(std::string& to) {
    const auto lead = static_cast<unsigned char>(text_[at_]);
    const int more = lead >= 0xF0 ? 3 : lead >= 0xE0 ? 2 : 1;
    if (lead < 0xC2 || lead > 0xF4 || text_.size() - at_ <= static_cast<std::size_t>(more)) fail();
    unsigned code = lead & (0x3Fu >> more);
    for (int i = 1; i <= more; ++i) {
      const auto next = static_cast<unsigned char>(text_[at_ + static_cast<std::size_t>(i)]);
      if ((next & 0xC0) != 0x80) fail();
      code = code << 6 | (next & 0x3F);
    }
    constexpr unsigned kLeast[] = {0, 0x80, 0x800, 0x10000};
    if (code < kLeast[more] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) fail();
    to += text_.substr(at_, static_cast<std::size_t>(more) + 1);
    at_ += static_cast<std::size_t>(more) + 1;
  }

  std::string string() {
    std::string result;
    for (++at_; at_ < text_.size();) {
      const auto c = static_cast<unsigned char>(text_[at_]);
      if (c == '"') {
        ++at_;
        return result;
      }
      if (c == '\\') {
        ++at_;
        escape(result);
      } else if (c >= 0x80) {
        copy_utf8(result);
      } else if (c < 0x20) {
        fail();
      } else {
        result.push_back(static_cast<char>(c));
        ++at_;
      }
    }
    fail();
  }

  std::string_view text_, name_;
  std::size_t at_ = 0, line_ = 1;
  int depth_ = 0;
  std::string path_;  // of the value at hand; long keys are shortened
};

void write(std::string& to, const std::string& text) {
  to += '"';
  for (const char c : text) {
    constexpr std::string_view kLetters = "\"\\bfnrt", kMeant = "\"\\\b\f\n\r\t";
    if (const std::size_t which = kMeant.find(c); which != std::string_view::npos) {
      to += '\\', to += kLetters[which];
    } else if (static_cast<unsigned char>(c) < 0x20) {
      to += fmt::format("\\u{:04x}", c);
    } else {
      to += c;
    }
  }
  to += '"';
}

void write(std::string& to, const Node& node) {
  if (node.as<std::nullptr_t>()) to += "null";
  if (const auto* b = node.as<bool>()) to += *b ? "true" : "false";
  if (const auto* i = node.as<std::int64_t>()) to += fmt::to_string(*i);
  if (const auto* u = node.as<std::uint64_t>()) to += fmt::to_string(*u);
  if (const auto* d = node.as<double>()) {
    const std::string shortest = fmt::format("{}", *d);
    to += shortest;
    if (shortest.find_first_of(".e") == std::string::npos) to += ".0";
  }
  if (const auto* s = node.as<std::string>()) write(to, *s);
  if (const auto* array = node.as<Array>()) {
    to += '[';
    for (const Node& item : *array) {
      if (&item != array->data()) to += ',';
      write(to, item);
    }
    to += ']';
  }
  if (const auto* object = node.as<Object>()) {
    to += '{';
    for (const Member& member : *object) {
      if (&member != object->data()) to += ',';
      write(to, member.key);
      to += ':';
      write(to, member.value);
    }
    to += '}';
  }
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

/// For messages, for example `line 7, "a.b[2]"`, without unknown parts.
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
  return Json(document_, &it->value, path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key));
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
  std::string text;
  write(text, as_node(value_));
  return text;
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
