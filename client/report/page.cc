#include "client/report/page.h"

#include <absl/strings/str_cat.h>

namespace isthmus::report {
namespace {

constexpr char kStyle[] = R"CSS(
:root { --ground: #fff; --ink: #202428; --faint: #5c646c; --line: #d8dce0; --box: #f4f6f8;
  --warn: #b54708; }
@media (prefers-color-scheme: dark) { :root { --ground: #14171a; --ink: #e4e7ea; --faint: #a0a8b0;
  --line: #363c42; --box: #1e2328; --warn: #ffb066; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 4rem; max-width: 76rem; background: var(--ground);
  color: var(--ink); font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { margin: 0; font-size: 1.6rem; } h2 { margin: 2.2rem 0 .6rem; font-size: 1.15rem;
  border-bottom: 1px solid var(--line); padding-bottom: .25rem; }
.sub { margin: .1rem 0 1rem; color: var(--faint); } p { margin: .5rem 0; max-width: 62rem; }
.tiles { display: flex; flex-wrap: wrap; gap: .6rem; }
.tiles div { background: var(--box); border-radius: 6px; padding: .5rem .9rem; min-width: 7rem; }
.tiles b { display: block; font-size: 1.3rem; } .tiles span { color: var(--faint); }
.advice { border-left: 4px solid var(--warn); background: var(--box); padding: .5rem .9rem;
  margin: .6rem 0; border-radius: 0 6px 6px 0; } .advice p { margin: .1rem 0; }
.wide { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: .88rem; min-width: 40%; }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; }
th, td { text-align: left; padding: .22rem .7rem .22rem 0; border-bottom: 1px solid var(--line);
  vertical-align: top; }
th { color: var(--faint); font-weight: 600; }
.long { min-width: 15rem; }
.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; } th.n { white-space: normal; }
figure { margin: 1rem 0; } figure svg { max-width: 100%; height: auto; display: block; }
figcaption { color: var(--faint); font-size: .9rem; }
.white { background: #fff; color: #202428; --ground: #fff; --faint: #5c646c; padding: .5rem;
  border-radius: 6px; width: fit-content; max-width: 100%; }
)CSS";

}  // namespace

Page::Page(const std::string& title, const std::string& subtitle) : title_(title) {
  absl::StrAppend(&body_, "<h1>", EscapeHtml(title), "</h1>\n<p class=\"sub\">",
                  EscapeHtml(subtitle), "</p>\n");
}

void Page::Section(const std::string& heading) {
  absl::StrAppend(&body_, "<h2>", EscapeHtml(heading), "</h2>\n");
}

void Page::Paragraph(const std::string& text) {
  body_ += FormatParagraph(text, TableFormat::kHtml);
}

void Page::Tiles(const std::vector<std::pair<std::string, std::string>>& tiles) {
  body_ += "<div class=\"tiles\">\n";
  for (const auto& [value, name] : tiles) {
    absl::StrAppend(&body_, "<div><b>", EscapeHtml(value), "</b><span>", EscapeHtml(name),
                    "</span></div>\n");
  }
  body_ += "</div>\n";
}

void Page::Advice(const std::string& what, const std::string& todo) {
  absl::StrAppend(&body_, "<div class=\"advice\"><p><b>", EscapeHtml(what), "</b></p><p>",
                  EscapeHtml(todo), "</p></div>\n");
}

void Page::Add(const Table& table) { body_ += Format(table, TableFormat::kHtml); }

void Page::Figure(const std::string& svg, const std::string& caption, bool on_white) {
  absl::StrAppend(&body_, "<figure", on_white ? " class=\"white\"" : "", ">\n", svg, "<figcaption>",
                  EscapeHtml(caption), "</figcaption></figure>\n");
}

std::string Page::Html() const {
  // The policy keeps a browser from running or loading anything, whatever a name might hold.
  return absl::StrCat(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "style-src 'unsafe-inline'; img-src data:\">\n<title>",
      EscapeHtml(title_), "</title>\n<style>", kStyle, "</style>\n</head>\n<body>\n", body_,
      "</body>\n</html>\n");
}

}  // namespace isthmus::report
