// Build tool: converts fonts to an atlas of signed distances with metrics, as C++ code.
//   bake_font FONT.ttf OUT.h [CHINESE_FONT.ttc TEXT_FILE …]
// FONT has the Latin characters, CHINESE_FONT the Chinese characters of the text files.
#define STB_TRUETYPE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wcast-qual"
#include <stb/stb_truetype.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

std::string content_of(const char* file) {
  std::ifstream in(file, std::ios::binary);
  return std::string((std::istreambuf_iterator<char>(in)), {});
}

struct Font {
  std::string bytes;
  stbtt_fontinfo info;

  bool open(const char* file) {
    bytes = content_of(file);
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    const bool opened = !bytes.empty() && stbtt_InitFont(&info, data, stbtt_GetFontOffsetForIndex(data, 0));
    if (!opened) std::fprintf(stderr, "%s: not a TrueType font\n", file);
    return opened;
  }
};

/// Adds the characters from U+3000 up: Chinese characters and punctuation in UTF-8.
void add_chinese(std::string_view text, std::set<int>& characters) {
  for (std::size_t i = 0; i + 2 < text.size(); ++i) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[i + k]); };
    if ((byte(0) & 0xf0) != 0xe0) continue;
    const int code = (byte(0) & 0x0f) << 12 | (byte(1) & 0x3f) << 6 | (byte(2) & 0x3f);
    if (code >= 0x3000) characters.insert(code);
  }
}

/// Adds the Chinese characters of a file. A catalogue of texts has one text per line; only texts that are drawn over a
/// picture are read.
void read_text(const std::string& file, std::set<int>& characters) {
  constexpr std::array<std::string_view, 4> kShown{"\"hud.", "\"tool.", "\"implant.note.", "\"op.quality."};
  const bool all = file.find("/texts/") == std::string::npos;
  std::istringstream lines(content_of(file.c_str()));
  for (std::string line; std::getline(lines, line);)
    if (all || std::any_of(kShown.begin(), kShown.end(), [&](auto prefix) { return line.starts_with(prefix); }))
      add_chinese(line, characters);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: bake_font FONT.ttf OUT.h [CHINESE_FONT.ttc TEXT_FILE …]\n");
    return 2;
  }
  Font latin, chinese;
  if (!latin.open(argv[1]) || (argc > 3 && !chinese.open(argv[3]))) return 2;
  constexpr int kSize = 36, kPadding = 5, kWidth = 512;
  const float latin_scale = stbtt_ScaleForPixelHeight(&latin.info, kSize);
  // Both fonts get the same em size.
  const float em = latin_scale / stbtt_ScaleForMappingEmToPixels(&latin.info, 1);
  const float chinese_scale = argc > 3 ? stbtt_ScaleForMappingEmToPixels(&chinese.info, em) : 0;
  std::set<int> drawn_in_chinese;
  for (int i = 4; i < argc; ++i) read_text(argv[i], drawn_in_chinese);
  std::vector<int> characters;  // codes of the characters, ascending
  for (int c = 32; c < 127; ++c) characters.push_back(c);
  for (int c = 0xa1; c <= 0xff; ++c) characters.push_back(c);  // Latin-1 letters, used by translated hints
  for (int c : {0x2013, 0x2014, 0x2019, 0x2026}) characters.push_back(c);
  characters.insert(characters.end(), drawn_in_chinese.begin(), drawn_in_chinese.end());

  struct Glyph {
    int code, x, y, w, h, left, top;
    float advance;
  };
  std::vector<Glyph> glyphs;
  std::vector<unsigned char> atlas;
  int x = 0, y = 0, row = 0;
  for (int c : characters) {
    const stbtt_fontinfo& font = drawn_in_chinese.contains(c) ? chinese.info : latin.info;
    const float scale = drawn_in_chinese.contains(c) ? chinese_scale : latin_scale;
    if (stbtt_FindGlyphIndex(&font, c) == 0) continue;
    Glyph g{c, 0, 0, 0, 0, 0, 0, 0};
    int advance = 0, bearing = 0;
    stbtt_GetCodepointHMetrics(&font, c, &advance, &bearing);
    g.advance = static_cast<float>(advance) * scale;
    unsigned char* sdf =
        stbtt_GetCodepointSDF(&font, scale, c, kPadding, 128, 128.0f / kPadding, &g.w, &g.h, &g.left, &g.top);
    if (sdf) {
      // Letters are separated by a gap, so that filtering does not mix them.
      if (x + g.w > kWidth) x = 0, y += row + 3, row = 0;
      row = row > g.h ? row : g.h;
      g.x = x, g.y = y;
      if (atlas.size() < static_cast<std::size_t>(kWidth) * (y + row))
        atlas.resize(static_cast<std::size_t>(kWidth) * (y + row));
      for (int j = 0; j < g.h; ++j)
        for (int i = 0; i < g.w; ++i) atlas[static_cast<std::size_t>((y + j) * kWidth + x + i)] = sdf[j * g.w + i];
      x += g.w + 3;
      stbtt_FreeSDF(sdf, nullptr);
    } else {
      g.w = g.h = 0;
    }
    glyphs.push_back(g);
  }
  std::FILE* out = std::fopen(argv[2], "w");
  if (!out) {
    std::fprintf(stderr, "%s: cannot write\n", argv[2]);
    return 2;
  }
  std::fprintf(out,
               "// Generated by bake_font. Lengths in pixels of the atlas; top is below the baseline's y = 0. Glyphs "
               "are sorted by "
               "code.\n#pragma once\n");
  std::fprintf(out, "namespace typodont::font {\nstruct Glyph { int code, x, y, w, h, left, top; float advance; };\n");
  std::fprintf(out, "inline constexpr int kSize = %d, kWidth = %d, kHeight = %d, kGlyphCount = %d;\n", kSize, kWidth,
               static_cast<int>(atlas.size()) / kWidth, static_cast<int>(glyphs.size()));
  std::fprintf(out, "inline constexpr Glyph kGlyphs[] = {\n");
  for (const Glyph& g : glyphs)
    std::fprintf(out, "{%d,%d,%d,%d,%d,%d,%d,%.4ff},\n", g.code, g.x, g.y, g.w, g.h, g.left, g.top,
                 static_cast<double>(g.advance));
  std::fprintf(out, "};\ninline constexpr unsigned char kAtlas[] = {");
  for (std::size_t i = 0; i < atlas.size(); ++i) std::fprintf(out, "%s%d,", i % 64 ? "" : "\n", atlas[i]);
  std::fprintf(out, "\n};\n}  // namespace typodont::font\n");
  return std::fclose(out) ? 2 : 0;
}
