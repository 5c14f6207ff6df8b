// A picture opens to the model that turns: from the page beside this one, or from the data in it.
(() => {
  const dialog = document.getElementById('turning'), frame = dialog.querySelector('iframe');
  const open = name => {
    const inside = document.getElementById(name);
    if (inside) {
      const bytes = Uint8Array.from(atob(inside.textContent), letter => letter.charCodeAt(0));
      frame.srcdoc = new TextDecoder().decode(bytes);
    } else {
      frame.removeAttribute('srcdoc');
      frame.src = name;
    }
    dialog.showModal();
  };
  document.addEventListener('click', event => {
    const asked = event.target.closest('[data-view]');
    if (asked) open(asked.dataset.view);
  });
  // What is not seen needs no memory.
  dialog.addEventListener('close', () => { frame.removeAttribute('srcdoc'); frame.src = 'about:blank'; });
})();
