// Corrections of the theme of mdBook for keyboards and screen readers.
'use strict';

(() => {
    // Code and tables that are wider than the page scroll. Without a mouse, only an element with the focus does.
    const markScrolling = () => {
        for (const box of document.querySelectorAll('main pre code, main .table-wrapper')) {
            if (box.scrollWidth > box.clientWidth || box.scrollHeight > box.clientHeight) {
                box.tabIndex = 0;
            } else {
                box.removeAttribute('tabindex');
            }
        }
    };
    markScrolling();
    addEventListener('load', markScrolling); // with the fonts of the page
    addEventListener('resize', markScrolling);

    // The switch of the sidebar is a label of a hidden box. The theme gives it attributes of a button, which a label
    // must not have, and no key reaches it.
    const toggle = document.getElementById('mdbook-sidebar-toggle');
    if (toggle) {
        toggle.setAttribute('role', 'button');
        toggle.tabIndex = 0;
        toggle.addEventListener('keydown', event => {
            if (event.key === 'Enter' || event.key === ' ') {
                event.preventDefault();
                toggle.click();
            }
        });
    }
})();
