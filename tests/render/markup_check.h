// A check that every tag is closed in order, and that quotes and angle brackets are where markup wants them.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace recede {

/// Empty when `markup` is balanced, else what is wrong. `void_tags` need no end (HTML's img, meta, br).
inline std::string find_markup_error(std::string_view markup,
                                     const std::vector<std::string>& void_tags = {}) {
  std::vector<std::string> open;
  for (std::size_t at = 0; at < markup.size(); ++at) {
    if (markup[at] == '>') return "a bare > near " + std::string(markup.substr(at, 40));
    if (markup[at] != '<') continue;
    if (markup.substr(at, 2) == "<!") {
      at = markup.find('>', at);
      continue;
    }
    std::size_t end = at + 1;
    bool quoted = false;
    while (end < markup.size() && (quoted || markup[end] != '>')) {
      if (markup[end] == '"') quoted = !quoted;
      if (markup[end] == '<') return "a bare < near " + std::string(markup.substr(end, 40));
      ++end;
    }
    if (end == markup.size()) return "an open tag at the end";
    const std::string_view tag = markup.substr(at + 1, end - at - 1);
    const std::string name(tag.substr(0, tag.find_first_of(" \n/", 1)));
    if (tag.front() == '/') {
      if (open.empty() || "/" + open.back() != name) return "unexpected <" + name + ">";
      open.pop_back();
    } else if (tag.back() != '/' && std::find(void_tags.begin(), void_tags.end(), name) == void_tags.end()) {
      open.push_back(name);
    }
    at = end;
  }
  return open.empty() ? "" : "<" + open.back() + "> stays open";
}

}  // namespace recede
