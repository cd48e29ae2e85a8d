// Tests HMAC-SHA256 with the vectors of RFC 4231, and signatures of files.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>

#include "engine/base/error.h"
#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "engine/session/signature.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using test::refusal, test::TemporaryFolder;
using testing::HasSubstr;

std::string hmac(std::string_view key, std::string_view message) {
  const auto bytes = [](std::string_view text) {
    return std::span(reinterpret_cast<const unsigned char*>(text.data()), text.size());
  };
  std::string text;
  for (const unsigned char byte : hmac_sha256(bytes(key), bytes(message))) text += fmt::format("{:02x}", byte);
  return text;
}
void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

struct Signature : testing::Test {
  const TemporaryFolder folder;
  SigningKey key;
  Signature() {
    make_key(folder / "key");
    key = load_key(folder / "key");
  }
};

TEST_F(Signature, TheCodeIsThatOfRfc4231) {
  EXPECT_EQ(hmac(std::string(20, '\x0b'), "Hi There"),
            "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7");
  EXPECT_EQ(hmac("Jefe", "what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(hmac(std::string(20, '\xaa'), std::string(50, '\xdd')),
            "773ea91e36800e46854db8ebd09181a72959098b3ef8c122d9635514ced565fe");
  EXPECT_EQ(hmac(std::string(131, '\xaa'), "Test Using Larger Than Block-Size Key - Hash Key First"),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
}

TEST_F(Signature, EveryChangedByteOfAFileIsNoticed) {
  std::string bytes;
  for (int i = 0; i < 3000; ++i) bytes += static_cast<char>(i * 7);
  write(folder / "s.h5", bytes);
  EXPECT_THAT(what_is_wrong_with_signature(folder / "s.h5", key), HasSubstr("no signature"));
  EXPECT_EQ(sign_session(folder / "s.h5", key), folder / "s.h5.sig");
  EXPECT_EQ(what_is_wrong_with_signature(folder / "s.h5", key), "");
  for (std::size_t at = 0; at < bytes.size(); at += 97) {
    std::string forged = bytes;
    forged[at] = static_cast<char>(forged[at] ^ 1);
    write(folder / "s.h5", forged);
    EXPECT_EQ(what_is_wrong_with_signature(folder / "s.h5", key), "the file changed after it was signed") << at;
  }
  write(folder / "s.h5", bytes + '\0');
  EXPECT_EQ(what_is_wrong_with_signature(folder / "s.h5", key), "the file changed after it was signed");
  write(folder / "s.h5", bytes.substr(0, bytes.size() - 1));
  EXPECT_EQ(what_is_wrong_with_signature(folder / "s.h5", key), "the file changed after it was signed");
}

TEST_F(Signature, AnotherKeyOrAForgedSignatureIsRefused) {
  make_key(folder / "b");
  const SigningKey &a = key, b = load_key(folder / "b");
  EXPECT_NE(a.bytes, b.bytes);
  write(folder / "s.h5", "a session");
  sign_session(folder / "s.h5", a);
  EXPECT_THAT(what_is_wrong_with_signature(folder / "s.h5", b), HasSubstr("of another key"));
  std::string text = test::read_text(folder / "s.h5.sig");
  // If the file only states the other key's name, its code still does not match.
  text.replace(text.find(a.id()), 16, b.id());
  write(folder / "s.h5.sig", text);
  EXPECT_EQ(what_is_wrong_with_signature(folder / "s.h5", b), "the file changed after it was signed");
  for (const std::string& wrong : {std::string(), text.substr(1), text + "x", std::string(text.size(), 'f')}) {
    write(folder / "s.h5.sig", wrong);
    EXPECT_THAT(what_is_wrong_with_signature(folder / "s.h5", a), HasSubstr("is no signature"));
  }
}

TEST_F(Signature, ReplacesASignatureButNoFileOfAnotherKindAlsoNotThroughALink) {
  write(folder / "s.h5", "a session");
  sign_session(folder / "s.h5", key);
  write(folder / "s.h5", "the same session, repaired");
  sign_session(folder / "s.h5", key);
  EXPECT_EQ(what_is_wrong_with_signature(folder / "s.h5", key), "");
  write(folder / "scene.json", "{}");
  std::filesystem::remove(folder / "s.h5.sig");
  std::filesystem::create_symlink(folder / "scene.json", folder / "s.h5.sig");
  EXPECT_THROW(sign_session(folder / "s.h5", key), Error);
  EXPECT_EQ(std::filesystem::file_size(folder / "scene.json"), 2u);
}

TEST_F(Signature, OfAnOpenedSessionIsOfTheBytesThatAreReadAlsoIfTheNameGetsAnotherFile) {
  const auto record = [&](const char* name, std::size_t ticks) {
    WriterOptions options;
    options.whole_or_nothing = true;
    SessionWriter writer(folder / name, test::some_header(), options);
    writer.append(test::random_ticks(ticks, 3));
    ASSERT_TRUE(writer.finish({}));
  };
  record("s.h5", 700), record("forged.h5", 500);
  sign_session(folder / "s.h5", key);
  const OpenedSession session(folder / "s.h5");
  const OpenedSession verified(folder / "s.h5");
  EXPECT_EQ(what_is_wrong_with_signature(verified, key), "");
  // another file of the same name
  std::filesystem::rename(folder / "forged.h5", folder / "s.h5");
  EXPECT_EQ(what_is_wrong_with_signature(session, key), "");
  EXPECT_EQ(SessionReader(session).tick_count(), 700u);
  EXPECT_EQ(SessionReader(verified).tick_count(), 700u);
  EXPECT_EQ(what_is_wrong_with_signature(folder / "s.h5", key), "the file changed after it was signed");
  EXPECT_EQ(SessionReader(folder / "s.h5").tick_count(), 500u);
}

TEST_F(Signature, OfAVerifiedSessionHoldsAlsoIfTheFileIsWrittenOverAfterwards) {
  {
    SessionWriter writer(folder / "s.h5", test::some_header());
    writer.append(test::random_ticks(700, 3));
    ASSERT_TRUE(writer.finish({}));
  }
  sign_session(folder / "s.h5", key);
  const OpenedSession verified(folder / "s.h5");
  require_signature(verified, folder / "key");
  std::fstream(folder / "s.h5", std::ios::binary | std::ios::in | std::ios::out) << std::string(100'000, 'x');
  EXPECT_EQ(SessionReader(verified).ticks().size(), 700u);
  EXPECT_THROW(SessionReader(folder / "s.h5"), Error);
}

TEST_F(Signature, AKeyIsReadableByItsOwnerAloneAndNeverOverwritten) {
  struct stat status {};
  ASSERT_EQ(stat((folder / "key").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_THAT(refusal([&] { make_key(folder / "key"); }), HasSubstr("expected a new file for the key"));
  chmod((folder / "key").c_str(), 0644);
  EXPECT_THAT(refusal([&] { (void)load_key(folder / "key"); }),
              HasSubstr("found a key that others may read, expected mode 0600: chmod 600"));
  write(folder / "word", "secret\n");
  chmod((folder / "word").c_str(), 0600);
  EXPECT_THAT(refusal([&] { (void)load_key(folder / "word"); }), HasSubstr("expected 64 hexadecimal digits"));
}

}  // namespace
}  // namespace typodont::session
