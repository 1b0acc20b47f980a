// The keyboard goes through the frames, unless the part that has the focus uses the key itself.

const KEY_STEPS = { ArrowLeft: -1, ArrowRight: 1, PageUp: -10, PageDown: 10 };

function frameOfKey(event) {
  if (event.key === "Home") return 0;
  if (event.key === "End") return store.group.axis.length - 1;
  const step = KEY_STEPS[event.key];
  return step === undefined ? null : store.frame + (event.shiftKey ? 10 * step : step);
}

function listenToKeys(bar) {
  document.addEventListener("keydown", (event) => {
    const within = (parts) => event.target instanceof Element && event.target.closest(parts) !== null;
    if (event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey || within("input, select, [role=application], .table-box")) return;
    const frame = frameOfKey(event);
    if (frame !== null) setFrame(frame);
    else if (event.key === " " && !within("button, summary, [role=button]")) bar.play();
    else return;
    event.preventDefault();
  });
}
