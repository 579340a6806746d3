// A block that begins "```toml design.toml" is a file: its name stands above it. "+" and "-3" after the name say that the block
// goes to the end of the file, or takes the place of its last three lines.
for (const code of document.querySelectorAll("pre > code[class*='.']")) {
    const words = [...code.classList];
    const name = words.findIndex(word => /^[\w-]+(\/[\w.-]+)*\.\w+$/.test(word));
    if (name < 0) continue;
    const how = words[name + 1] || "";
    const caption = document.createElement("div");
    caption.className = "file-name";
    caption.textContent = how === "+" ? `${words[name]}, added at the end`
        : /^-\d+$/.test(how) ? `${words[name]}, in place of the last ${how.slice(1)} lines`
        : words[name];
    code.parentElement.before(caption);
}
