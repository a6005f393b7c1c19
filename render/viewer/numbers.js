// Numbers as the rest of the report writes them (render/detail/markup.h).

export const grouped = (number) => String(number).replace(/\B(?=(\d{3})+$)/g, "\u202f");

export function short(number) {
  if (number === 0) return "0";
  const [digits, exponent] = number.toExponential(2).split("e");
  if (exponent >= -3 && exponent < 6) return Number(number.toPrecision(3)).toFixed(Math.max(0, 2 - exponent));
  return digits + "×10" + Number(exponent).toString().replace("-", "⁻").replace(/\d/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]);
}
