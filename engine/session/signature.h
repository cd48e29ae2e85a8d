// Keyed signatures of session files: HMAC-SHA256 over the file's bytes, kept beside it in SESSION.h5.sig. Who has no
// key can neither make nor change a signed session unnoticed. Set-up time; any thread; throws Error.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace typodont::session {

/// A secret of 32 bytes. Its file: 64 hexadecimal digits and a line end, readable by its owner alone.
struct SigningKey {
  std::array<unsigned char, 32> bytes{};
  /// 16 hexadecimal digits that name the key and tell nothing of it.
  std::string id() const;
};

SigningKey load_key(const std::filesystem::path& file);
/// From the system's source of randomness, to a new file with mode 0600. An Error where the file exists.
void make_key(const std::filesystem::path& file);

/// RFC 2104 with SHA-256.
std::array<unsigned char, 32> hmac_sha256(std::span<const unsigned char> key, std::span<const unsigned char> message);

/// SESSION.h5.sig
std::filesystem::path signature_file(const std::filesystem::path& session);
/// Signs the file as it is now and returns the signature's file, whole or not at all.
std::filesystem::path sign_session(const std::filesystem::path& session, const SigningKey& key);
/// Empty: the signature is of this key and these bytes. Else why not, one clause: "no signature (…)", "the signature is
/// of another key, …", "the file changed after it was signed".
std::string what_is_wrong_with_signature(const std::filesystem::path& session, const SigningKey& key);
/// Throws RunFailure where something is, and Error where the key is none.
void require_signature(const std::filesystem::path& session, const std::filesystem::path& key);

}  // namespace typodont::session
