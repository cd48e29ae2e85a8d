#include "engine/session/signature.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/json.h"

namespace typodont::session {

namespace {

constexpr std::string_view kFormat = "typodont-signature-1 HMAC-SHA256";

std::string hex(std::span<const unsigned char> bytes) {
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

std::optional<std::array<unsigned char, 32>> from_hex(std::string_view text) {
  if (text.size() != 64) return std::nullopt;
  std::array<unsigned char, 32> bytes{};
  for (std::size_t i = 0; i < 64; ++i) {
    const char c = text[i];
    const int digit = c >= '0' && c <= '9'   ? c - '0'
                      : c >= 'a' && c <= 'f' ? c - 'a' + 10
                      : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                             : -1;
    if (digit < 0) return std::nullopt;
    bytes[i / 2] = static_cast<unsigned char>(16 * bytes[i / 2] + digit);
  }
  return bytes;
}

std::array<unsigned char, 32> code_of(const OpenedSession& session, const SigningKey& key) {
  const std::span<const std::byte> bytes = session.bytes();
  return hmac_sha256(key.bytes, {reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
}

}  // namespace

std::array<unsigned char, 32> hmac_sha256(std::span<const unsigned char> key, std::span<const unsigned char> message) {
  std::array<unsigned char, 32> code{};
  unsigned size = 0;
  if (!HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), message.data(), message.size(), code.data(),
            &size) ||
      size != code.size())
    throw RunFailure("the cryptographic library computes no HMAC-SHA256");
  return code;
}

std::string SigningKey::id() const {
  constexpr std::string_view kPurpose = "typodont key id";
  const auto code = hmac_sha256(bytes, {reinterpret_cast<const unsigned char*>(kPurpose.data()), kPurpose.size()});
  return hex(std::span(code).first(8));
}

SigningKey load_key(const std::filesystem::path& file) {
  std::string text = read_input(file, InputKind::kAny);
  struct stat status {};
  if (stat(file.c_str(), &status) == 0 && (status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    throw Error(file.string(), "", "a key that others may read", "mode 0600: chmod 600");
  }
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  const auto bytes = from_hex(text);
  OPENSSL_cleanse(text.data(), text.size());
  if (!bytes) throw Error(file.string(), "", "no key", "64 hexadecimal digits, as typodont sign --new-key writes them");
  return {*bytes};
}

void make_key(const std::filesystem::path& file) {
  SigningKey key;
  if (RAND_bytes(key.bytes.data(), static_cast<int>(key.bytes.size())) != 1)
    throw RunFailure("the system gives no random numbers");
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (fd < 0) throw Error(file.string(), "", std::strerror(errno), "a new file for the key");
  const std::string text = hex(key.bytes) + "\n";
  const bool written = write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && fsync(fd) == 0;
  close(fd);
  if (!written) {
    unlink(file.c_str());
    throw Error(file.string(), "", "a key that could not be written", "a writable place");
  }
}

std::filesystem::path signature_file(const std::filesystem::path& session) {
  return session.string() + ".sig";
}

namespace {

/// Throws Error if `file` exists and is not a signature. For example, `file` could be a link to any other file.
void require_replaceable(const std::filesystem::path& file) {
  std::error_code code;
  if (!std::filesystem::exists(file, code) || std::filesystem::file_size(file, code) == 0) return;
  // the format's name without the version number; a signature file of any version begins with this text
  constexpr std::string_view kFamily = kFormat.substr(0, kFormat.find('1'));
  std::string head(kFamily.size(), '\0');
  std::ifstream(file, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head != kFamily)
    throw Error(file.string(), "", "a file of another kind", "a signature (.sig) to replace, or a new name");
}

}  // namespace

std::filesystem::path sign_session(const OpenedSession& session, const SigningKey& key) {
  const auto code = code_of(session, key);
  const std::filesystem::path file = signature_file(session.file());
  require_replaceable(file);
  write_file_atomically(file, fmt::format("{} {} {}\n", kFormat, key.id(), hex(code)));
  return file;
}

std::string what_is_wrong_with_signature(const OpenedSession& session, const SigningKey& key) {
  const std::filesystem::path file = signature_file(session.file());
  std::error_code code;
  if (!std::filesystem::exists(file, code)) return fmt::format("no signature ({})", file.string());
  const std::string text = read_input(file, InputKind::kJson);
  const std::size_t at = kFormat.size() + 1, id_end = at + 16;
  const auto signed_code = text.size() == id_end + 1 + 64 + 1 && text.starts_with(kFormat) && text.back() == '\n'
                               ? from_hex(std::string_view(text).substr(id_end + 1, 64))
                               : std::nullopt;
  if (!signed_code) return fmt::format("{} is no signature", file.string());
  if (text.substr(at, 16) != key.id())
    return fmt::format("the signature is of another key, {} instead of {}", text.substr(at, 16), key.id());
  const auto computed = code_of(session, key);
  if (CRYPTO_memcmp(computed.data(), signed_code->data(), computed.size()) != 0)
    return "the file changed after it was signed";
  return "";
}

void require_signature(const OpenedSession& session, const std::filesystem::path& key) {
  const std::string wrong = what_is_wrong_with_signature(session, load_key(key));
  if (!wrong.empty()) throw RunFailure(fmt::format("{}: {}", session.file().string(), wrong));
}

}  // namespace typodont::session
