// Signatures of session files: HMAC-SHA256 over the file's bytes, stored beside the file in SESSION.h5.sig. Without the
// key nobody can create or change a signed session unnoticed. Set-up time; any thread; throws Error.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace typodont::session {

/// A secret key of 32 bytes. Its file contains 64 hexadecimal digits and a line end; only the owner may read it.
struct SigningKey {
  std::array<unsigned char, 32> bytes{};
  /// Identifier of the key: 16 hexadecimal digits, which do not reveal the key.
  std::string id() const;
};

SigningKey load_key(const std::filesystem::path& file);
/// Writes a random key from the operating system to a new file with mode 0600. Throws Error if the file exists.
void make_key(const std::filesystem::path& file);

/// HMAC according to RFC 2104 with SHA-256.
std::array<unsigned char, 32> hmac_sha256(std::span<const unsigned char> key, std::span<const unsigned char> message);

/// Path of a session's signature: SESSION.h5.sig
std::filesystem::path signature_file(const std::filesystem::path& session);
/// Signs the present content of the file. Returns the path of the signature file, which is written completely or not at
/// all.
std::filesystem::path sign_session(const std::filesystem::path& session, const SigningKey& key);
/// Checks a signature. Returns an empty text if the signature matches this key and these bytes. Otherwise returns the
/// reason as a clause: "no signature (…)", "the signature is of another key, …", "the file changed after it was
/// signed".
std::string what_is_wrong_with_signature(const std::filesystem::path& session, const SigningKey& key);
/// Throws RunFailure if the signature is wrong, and Error if the key is invalid.
void require_signature(const std::filesystem::path& session, const std::filesystem::path& key);

}  // namespace typodont::session
