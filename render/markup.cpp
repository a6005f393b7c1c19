#include <recede/render/detail/markup.h>

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace recede::detail {

std::string escape_markup(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    }
  }
  return escaped;
}

std::string grouped(std::size_t number) {
  const std::string digits = std::to_string(number);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += "\u202f";
    text += digits[i];
  }
  return text;
}

std::string short_number(double number) {
  if (number == 0) return "0";
  const double size = std::abs(number);
  if (!std::isfinite(number)) return std::isnan(number) ? "not a number" : number > 0 ? "∞" : "−∞";
  if (size >= 0.001 && size < 999'500) {
    // Rounding first decides the number of digits: 999.96 shows as 1000, not 1000.0.
    const double rounded = std::stod(fmt::format("{:.2e}", number));
    const int decimals = std::max(0, 2 - static_cast<int>(std::floor(std::log10(std::abs(rounded)) + 1e-12)));
    return fmt::format("{:.{}f}", rounded, decimals);
  }
  constexpr std::array<std::string_view, 10> k_raised{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  const std::string text = fmt::format("{:.2e}", number);
  const std::size_t mark = text.find('e');
  const int exponent = std::stoi(text.substr(mark + 1));
  std::string raised = exponent < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(exponent)))
    raised += k_raised[static_cast<std::size_t>(digit - '0')];
  return text.substr(0, mark) + "×10" + raised;
}

std::string percent(double share) { return short_number(100 * share) + " %"; }

}  // namespace recede::detail
