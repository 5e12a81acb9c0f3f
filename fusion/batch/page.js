"use strict";
// filters by light and text; a click on a head sorts by that column, another click the other way round
addEventListener("DOMContentLoaded", () => {
  const table = document.getElementById("batch");
  const body = table.tBodies[0];
  const rows = Array.from(body.rows);
  const text = document.getElementById("batch-text");
  const boxes = Array.from(document.querySelectorAll(".batch-light"));
  const count = document.getElementById("batch-count");
  const filter = () => {
    const lights = new Set(boxes.filter((box) => box.checked).map((box) => box.value));
    const words = text.value.toLowerCase().split(/\s+/).filter(Boolean);
    let seen = 0;
    for (const row of rows) {
      const said = row.textContent.toLowerCase();
      const there = lights.has(row.dataset.light) && words.every((word) => said.includes(word));
      row.hidden = !there;
      seen += there ? 1 : 0;
    }
    count.textContent = `${seen} of ${rows.length} shown`;
  };
  const value = (row, column) => {
    const cell = row.cells[column];
    return cell.dataset.value === undefined ? cell.textContent : Number(cell.dataset.value);
  };
  Array.from(table.tHead.rows[0].cells).forEach((head, column) => {
    let way = -1;
    const sort = () => {
      way = -way;
      const compare = (a, b) => (a < b ? -way : a > b ? way : 0);
      rows.sort((a, b) => {
        const x = value(a, column), y = value(b, column);
        if (typeof x !== typeof y) return typeof x === "number" ? -1 : 1; // rows without a number come last
        return compare(x, y);
      });
      body.append(...rows);
      for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", way > 0 ? "ascending" : "descending");
    };
    head.addEventListener("click", sort);
    head.addEventListener("keydown", (event) => event.key === "Enter" && sort());
  });
  text.addEventListener("input", filter);
  boxes.forEach((box) => box.addEventListener("change", filter));
  filter();
});
